//! Parameters of a vehicle: all of them, one of them, and setting one.
//! (sketch: signatures only, bodies follow)
// ParamList::new(config: &TransferConfig, now)                         Value = Vec<Param>
// ParamRead::new(config, name: ParamName, now)                         Value = Param
// ParamSet::new(config, name: ParamName, value: f64, now)              Value = Param (type and range checked against what the vehicle says)
