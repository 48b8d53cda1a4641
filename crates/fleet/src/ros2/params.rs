//! Parameters of a plane's autopilot as ROS 2 has those of a node, which is how MAVROS 2 shows them; and MAVROS's own
//! services beside.

use vencejo_proto::param::{Param, ParamValue};

use super::cdr::{BadCdr, Cdr};
use super::message::{
    DescribeParameters, Descriptors, GetParameterTypes, GetParameters, Kinds, ListParameters, ListParametersResult,
    ListWanted, Listed, NamesWanted, ParamPull, ParamPullWanted, ParamPulled, ParamSetV2, ParamSetWanted, ParamWritten,
    Parameter, ParameterDescriptor, ParameterValue, ParametersWanted, SetAtOnce, SetParameters,
    SetParametersAtomically, SetParametersResult, SetResults, Values,
};
use super::offer::{Ended, Known, Offer, Wanted, Wish, offer};

/// `rcl_interfaces/ParameterType`.
const NOT_SET: u8 = 0;
const BOOL: u8 = 1;
const INTEGER: u8 = 2;
const DOUBLE: u8 = 3;

/// The name of the node that has them, below MAVROS's.
pub const NODE: &str = "param";
/// How the names of its services begin.
pub const BELOW: &str = "param/";

/// A value that is none.
fn not_set() -> ParameterValue {
    ParameterValue {
        r#type: NOT_SET,
        bool_value: false,
        integer_value: 0,
        double_value: 0.0,
        string_value: String::new(),
        byte_array_value: Vec::new(),
        bool_array_value: Vec::new(),
        integer_array_value: Vec::new(),
        double_array_value: Vec::new(),
        string_array_value: Vec::new(),
    }
}

/// The value of a parameter: a double where it is one, else an integer.
pub fn value_of(param: &Param) -> ParameterValue {
    match param.value {
        ParamValue::F32(value) => ParameterValue { r#type: DOUBLE, double_value: value.into(), ..not_set() },
        // Exact: it has 32 bits.
        #[expect(clippy::cast_possible_truncation, reason = "a whole number of 32 bits")]
        whole => ParameterValue { r#type: INTEGER, integer_value: whole.as_f64() as i64, ..not_set() },
    }
}

/// The number that a value stands for.
///
/// # Errors
/// That it is none, in words.
pub fn number(value: &ParameterValue) -> Result<f64, String> {
    match value.r#type {
        BOOL => Ok(f64::from(u8::from(value.bool_value))),
        #[expect(clippy::cast_precision_loss, reason = "what is not exact is out of a parameter's range")]
        INTEGER => Ok(value.integer_value as f64),
        DOUBLE => Ok(value.double_value),
        _ => Err("a parameter is a number".to_owned()),
    }
}

/// The services of a plane's parameters.
pub(super) fn offers() -> [Offer; 8] {
    [
        offer::<ParamPull>("param/pull", pull, |ended| {
            let param_received = ended.as_ref().map_or(0, |done| done.count);
            ParamPulled { success: ended.is_ok(), param_received }.to_bytes()
        }),
        offer::<ParamSetV2>("param/set", set, |ended| {
            let written = known(ended).first().and_then(|(_, value)| value.as_ref().ok());
            ParamWritten { success: written.is_some(), value: written.cloned().unwrap_or_else(not_set) }.to_bytes()
        }),
        offer::<GetParameters>("param/get_parameters", get, |ended| {
            Values {
                values: known(ended).iter().map(|(_, value)| value.clone().unwrap_or_else(|_| not_set())).collect(),
            }
            .to_bytes()
        }),
        offer::<GetParameterTypes>("param/get_parameter_types", get, |ended| {
            Kinds { types: known(ended).iter().map(|(_, value)| kind(value)).collect() }.to_bytes()
        }),
        offer::<DescribeParameters>("param/describe_parameters", get, |ended| {
            Descriptors { descriptors: known(ended).iter().map(described).collect() }.to_bytes()
        }),
        offer::<ListParameters>("param/list_parameters", list, |ended| {
            let names = known(ended).iter().map(|(name, _)| name.clone()).collect();
            Listed { result: ListParametersResult { names, prefixes: Vec::new() } }.to_bytes()
        }),
        offer::<SetParameters>("param/set_parameters", set_each, |ended| {
            SetResults { results: known(ended).iter().map(|(_, value)| result(value)).collect() }.to_bytes()
        }),
        offer::<SetParametersAtomically>("param/set_parameters_atomically", set_at_once, |ended| {
            let first = match (ended, known(ended).first()) {
                (Err(failed), _) => result(&Err(failed.why.clone())),
                (Ok(_), Some((_, value))) => result(value),
                (Ok(_), None) => result(&Ok(not_set())),
            };
            SetAtOnce { result: first }.to_bytes()
        }),
    ]
}

fn known(ended: &Ended) -> &[Known] {
    ended.as_ref().map_or(&[], |done| &done.params)
}

fn kind(value: &Result<ParameterValue, String>) -> u8 {
    value.as_ref().map_or(NOT_SET, |value| value.r#type)
}

fn result(value: &Result<ParameterValue, String>) -> SetParametersResult {
    let reason = value.as_ref().err().cloned().unwrap_or_default();
    SetParametersResult { successful: value.is_ok(), reason }
}

fn described((name, value): &Known) -> ParameterDescriptor {
    ParameterDescriptor {
        name: name.clone(),
        r#type: kind(value),
        description: String::new(),
        additional_constraints: String::new(),
        read_only: false,
        dynamic_typing: false,
        floating_point_range: Vec::new(),
        integer_range: Vec::new(),
    }
}

fn pull(bytes: &[u8]) -> Result<Wish, BadCdr> {
    ParamPullWanted::from_bytes(bytes)?;
    Ok(Wish::Params(None))
}

fn list(bytes: &[u8]) -> Result<Wish, BadCdr> {
    ListWanted::from_bytes(bytes)?;
    Ok(Wish::Params(None))
}

fn get(bytes: &[u8]) -> Result<Wish, BadCdr> {
    Ok(Wish::Params(Some(NamesWanted::from_bytes(bytes)?.names)))
}

fn set(bytes: &[u8]) -> Result<Wish, BadCdr> {
    let ParamSetWanted { param_id, value, .. } = ParamSetWanted::from_bytes(bytes)?;
    Ok(Wish::SetParams(vec![(param_id, number(&value))]))
}

fn numbers(bytes: &[u8]) -> Result<Wanted, BadCdr> {
    let wanted = ParametersWanted::from_bytes(bytes)?.parameters;
    Ok(wanted.into_iter().map(|Parameter { name, value }| (name, number(&value))).collect())
}

fn set_each(bytes: &[u8]) -> Result<Wish, BadCdr> {
    Ok(Wish::SetParams(numbers(bytes)?))
}

/// An autopilot is given one after the other.
fn set_at_once(bytes: &[u8]) -> Result<Wish, BadCdr> {
    let wanted = numbers(bytes)?;
    Ok(if wanted.len() > 1 { Wish::SetAtOnce } else { Wish::SetParams(wanted) })
}

#[cfg(test)]
mod tests {
    use vencejo_proto::param::ParamName;

    use super::super::offer::{Done, Failed};
    use super::*;

    fn double(value: f64) -> ParameterValue {
        ParameterValue { r#type: DOUBLE, double_value: value, ..not_set() }
    }

    #[test]
    fn a_value_is_a_number_of_its_own_kind() {
        let param = |value| Param::new(ParamName::new("ANY").expect("a name"), value);
        assert_eq!(value_of(&param(ParamValue::F32(0.5))), double(0.5));
        let whole = value_of(&param(ParamValue::I32(-7)));
        assert_eq!((whole.r#type, whole.integer_value, number(&whole)), (INTEGER, -7, Ok(-7.0)));
        assert_eq!(number(&double(1.5)), Ok(1.5));
        assert_eq!(number(&ParameterValue { r#type: BOOL, bool_value: true, ..not_set() }), Ok(1.0));
        let text = ParameterValue { r#type: 4, string_value: "7".into(), ..not_set() };
        assert!(number(&text).is_err() && number(&not_set()).is_err());
    }

    #[test]
    fn each_is_asked_for_and_told_as_a_node_does() {
        let offers = offers();
        let find = |name: &str| *offers.iter().find(|offer| offer.name == format!("param/{name}")).expect("a service");
        let names = NamesWanted { names: vec!["ROLL_LIMIT_DEG".into(), "NONE".into()] }.to_bytes();
        for name in ["get_parameters", "get_parameter_types", "describe_parameters"] {
            let wish = Wish::Params(Some(vec!["ROLL_LIMIT_DEG".into(), "NONE".into()]));
            assert_eq!((find(name).read)(&names), Ok(wish), "{name}");
        }
        let one = Parameter { name: "ROLL_LIMIT_DEG".into(), value: double(45.0) };
        let set = |parameters: Vec<Parameter>| ParametersWanted { parameters }.to_bytes();
        let wish = Wish::SetParams(vec![("ROLL_LIMIT_DEG".into(), Ok(45.0))]);
        for name in ["set_parameters", "set_parameters_atomically"] {
            assert_eq!((find(name).read)(&set(vec![one.clone()])).as_ref(), Ok(&wish), "{name}");
        }
        assert_eq!((find("set_parameters_atomically").read)(&set(vec![one.clone(), one])), Ok(Wish::SetAtOnce));
        let wanted = ParamSetWanted { force_set: false, param_id: "ROLL_LIMIT_DEG".into(), value: double(45.0) };
        assert_eq!((find("set").read)(&wanted.to_bytes()), Ok(wish));

        let params = vec![("ROLL_LIMIT_DEG".into(), Ok(double(45.0))), ("NONE".into(), Err("no such".into()))];
        let ended = Ok(Done { params, ..Done::default() });
        let told = |name: &str| (find(name).write)(&ended);
        assert_eq!(
            Values::from_bytes(&told("get_parameters")).map(|told| told.values),
            Ok(vec![double(45.0), not_set()])
        );
        assert_eq!(Kinds::from_bytes(&told("get_parameter_types")).map(|told| told.types), Ok(vec![3, 0]));
        let descriptors = Descriptors::from_bytes(&told("describe_parameters")).expect("descriptors").descriptors;
        assert_eq!((descriptors[0].name.as_str(), descriptors[0].r#type), ("ROLL_LIMIT_DEG", 3));
        let names = Listed::from_bytes(&told("list_parameters")).map(|told| told.result.names);
        assert_eq!(names, Ok(vec!["ROLL_LIMIT_DEG".into(), "NONE".into()]));
        let results = SetResults::from_bytes(&told("set_parameters")).expect("results").results;
        assert!(results[0].successful && !results[1].successful && results[1].reason == "no such");
        let refused = (find("set_parameters_atomically").write)(&Err(Failed::from("one after the other")));
        let refused = SetAtOnce::from_bytes(&refused).expect("a result").result;
        assert!(!refused.successful && refused.reason == "one after the other");
        let told = ParamWritten::from_bytes(&told("set")).expect("an answer");
        assert!(told.success && told.value == double(45.0));
    }
}
