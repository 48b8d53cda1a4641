//! Parameters that ROS 2 asks for, read from the vehicle and written to it.

use std::collections::BTreeMap;

use vencejo_station::VehicleHandle;
use vencejo_vehicle::{Reply, Request};

use super::ends::end_of;
use crate::ros2::message::ParameterValue;
use crate::ros2::offer::{Done, Ended, Failed, Wanted};
use crate::ros2::params::value_of;

/// Parameters that are read one by one at most; for more all are read, which takes less.
const ONE_BY_ONE: usize = 16;

/// Reads those with these names, or all.
pub(super) async fn read(vehicle: &VehicleHandle, names: Option<Vec<String>>) -> Ended {
    let Some(names) = names else {
        let params: Vec<_> = all(vehicle).await?.into_iter().map(|(name, value)| (name, Ok(value))).collect();
        let count = u32::try_from(params.len()).unwrap_or(u32::MAX);
        return Ok(Done { words: format!("{count} parameters"), count, params });
    };
    let mut params = Vec::new();
    if names.len() > ONE_BY_ONE {
        match all(vehicle).await {
            Ok(all) => {
                let missing = || "the vehicle has no such parameter".to_owned();
                params.extend(names.into_iter().map(|name| {
                    let value = all.get(&name).cloned().ok_or_else(missing);
                    (name, value)
                }));
            }
            Err(failed) => return Ok(Done::without(names, &failed.why)),
        }
    } else {
        for name in names {
            let value = one(vehicle, Request::ParamRead { name: name.clone() }).await;
            params.push((name, value));
        }
    }
    Ok(Done { params, ..Done::default() })
}

/// Writes parameters, one after the other.
pub(super) async fn write(vehicle: &VehicleHandle, wanted: Wanted) -> Ended {
    let mut params = Vec::new();
    for (name, value) in wanted {
        let value = match value {
            Ok(value) => one(vehicle, Request::ParamSet { name: name.clone(), value }).await,
            Err(why) => Err(why),
        };
        params.push((name, value));
    }
    Ok(Done { params, ..Done::default() })
}

async fn all(vehicle: &VehicleHandle) -> Result<BTreeMap<String, ParameterValue>, Failed> {
    match end_of(vehicle.request(Request::ParamList)).await? {
        Reply::Parameters(all) => Ok(all.iter().map(|param| (param.name.to_string(), value_of(param))).collect()),
        _ => Err("the parameters were not read".into()),
    }
}

async fn one(vehicle: &VehicleHandle, request: Request) -> Result<ParameterValue, String> {
    match end_of(vehicle.request(request)).await {
        Ok(Reply::Parameter(param)) => Ok(value_of(&param)),
        Ok(_) => Err("the parameter was not read".to_owned()),
        Err(failed) => Err(failed.why),
    }
}
