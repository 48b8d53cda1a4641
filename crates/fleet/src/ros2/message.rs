//! The messages and services of ROS 2 that we speak: fields in the order of their definitions, and their type hashes
//! (REP-2016).
//!
//! Hashes are those of Humble's, Jazzy's and Kilted's definitions, which are the same; `tests/fleet/test_ros2.py` works
//! each of them out anew with rosbags. Those of `mavros_msgs` and `geographic_msgs` come from their fields; constants
//! and comments do not count.

use super::cdr::{BadCdr, Cdr, Reader, Writer};

/// A message that can be a topic's.
pub trait Message: Cdr {
    /// Such as `sensor_msgs/msg/Imu`.
    const TYPE: &'static str;
    /// `RIHS01_…`.
    const HASH: &'static str;
}

/// A service.
pub trait Service {
    /// Such as `std_srvs/srv/SetBool`.
    const TYPE: &'static str;
    /// `RIHS01_…`.
    const HASH: &'static str;
    /// What is asked.
    type Request: Cdr;
    /// What is answered.
    type Response: Cdr;
}

macro_rules! structs {
    ($($(#[$doc:meta])* $name:ident { $($field:ident: $kind:ty),* $(,)? })*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq)]
        #[allow(missing_docs, reason = "the names are those of the definition")]
        pub struct $name {
            $(pub $field: $kind,)*
        }

        impl Cdr for $name {
            fn put(&self, out: &mut Writer) {
                $(self.$field.put(out);)*
            }

            fn take(from: &mut Reader<'_>) -> Result<Self, BadCdr> {
                Ok(Self { $($field: Cdr::take(from)?,)* })
            }
        }
    )*};
}

macro_rules! messages {
    ($($name:ident = $package:literal / $hash:literal;)*) => {
        $(impl Message for $name {
            const TYPE: &'static str = concat!($package, "/msg/", stringify!($name));
            const HASH: &'static str = concat!("RIHS01_", $hash);
        })*
        /// Type and hash of each message.
        pub const MESSAGES: &[(&str, &str)] = &[$(($name::TYPE, $name::HASH),)*];
    };
}

macro_rules! services {
    ($($(#[$doc:meta])* $name:ident: $request:ty => $response:ty = $package:literal / $hash:literal;)*) => {
        $($(#[$doc])*
        #[derive(Debug, Clone, Copy)]
        pub struct $name;

        impl Service for $name {
            const TYPE: &'static str = concat!($package, "/srv/", stringify!($name));
            const HASH: &'static str = concat!("RIHS01_", $hash);
            type Request = $request;
            type Response = $response;
        })*
        /// Type and hash of each service.
        pub const SERVICES: &[(&str, &str)] = &[$(($name::TYPE, $name::HASH),)*];
    };
}

structs! {
    /// `builtin_interfaces/Time`: UTC since 1970, s and ns.
    Time { sec: i32, nanosec: u32 }
    /// `std_msgs/Header`.
    Header { stamp: Time, frame_id: String }
    /// `geometry_msgs/Vector3`.
    Vector3 { x: f64, y: f64, z: f64 }
    /// `geometry_msgs/Quaternion`.
    Quaternion { x: f64, y: f64, z: f64, w: f64 }
    /// `geometry_msgs/Pose`; a `Point` has the fields of a vector.
    Pose { position: Vector3, orientation: Quaternion }
    /// `geometry_msgs/PoseStamped`.
    PoseStamped { header: Header, pose: Pose }
    /// `geometry_msgs/PoseWithCovariance`.
    PoseWithCovariance { pose: Pose, covariance: [f64; 36] }
    /// `geometry_msgs/Twist`.
    Twist { linear: Vector3, angular: Vector3 }
    /// `geometry_msgs/TwistStamped`.
    TwistStamped { header: Header, twist: Twist }
    /// `geometry_msgs/TwistWithCovariance`.
    TwistWithCovariance { twist: Twist, covariance: [f64; 36] }
    /// `geometry_msgs/TwistWithCovarianceStamped`.
    TwistWithCovarianceStamped { header: Header, twist: TwistWithCovariance }
    /// `geometry_msgs/Transform`.
    Transform { translation: Vector3, rotation: Quaternion }
    /// `geometry_msgs/TransformStamped`.
    TransformStamped { header: Header, child_frame_id: String, transform: Transform }
    /// `tf2_msgs/TFMessage`.
    TFMessage { transforms: Vec<TransformStamped> }
    /// `nav_msgs/Odometry`.
    Odometry { header: Header, child_frame_id: String, pose: PoseWithCovariance, twist: TwistWithCovariance }
    /// `nav_msgs/Path`.
    Path { header: Header, poses: Vec<PoseStamped> }
    /// `sensor_msgs/NavSatStatus`.
    NavSatStatus { status: i8, service: u16 }
    /// `sensor_msgs/NavSatFix`: height above the ellipsoid, m.
    NavSatFix {
        header: Header, status: NavSatStatus, latitude: f64, longitude: f64, altitude: f64,
        position_covariance: [f64; 9], position_covariance_type: u8,
    }
    /// `sensor_msgs/Imu`.
    Imu {
        header: Header, orientation: Quaternion, orientation_covariance: [f64; 9], angular_velocity: Vector3,
        angular_velocity_covariance: [f64; 9], linear_acceleration: Vector3, linear_acceleration_covariance: [f64; 9],
    }
    /// `sensor_msgs/BatteryState`: V, °C, A (negative while it discharges), Ah, 0 to 1.
    BatteryState {
        header: Header, voltage: f32, temperature: f32, current: f32, charge: f32, capacity: f32, design_capacity: f32,
        percentage: f32, power_supply_status: u8, power_supply_health: u8, power_supply_technology: u8, present: bool,
        cell_voltage: Vec<f32>, cell_temperature: Vec<f32>, location: String, serial_number: String,
    }
    /// `sensor_msgs/TimeReference`.
    TimeReference { header: Header, time_ref: Time, source: String }
    /// `diagnostic_msgs/KeyValue`.
    KeyValue { key: String, value: String }
    /// `diagnostic_msgs/DiagnosticStatus`.
    DiagnosticStatus { level: u8, name: String, message: String, hardware_id: String, values: Vec<KeyValue> }
    /// `diagnostic_msgs/DiagnosticArray`.
    DiagnosticArray { header: Header, status: Vec<DiagnosticStatus> }
    /// `std_msgs/Float64`.
    Float64 { data: f64 }
    /// `rcl_interfaces/Log`.
    Log { stamp: Time, level: u8, name: String, msg: String, file: String, function: String, line: u32 }
    /// `geographic_msgs/GeoPoint`.
    GeoPoint { latitude: f64, longitude: f64, altitude: f64 }
    /// `geographic_msgs/GeoPose`.
    GeoPose { position: GeoPoint, orientation: Quaternion }
    /// `geographic_msgs/GeoPoseStamped`.
    GeoPoseStamped { header: Header, pose: GeoPose }
    /// `mavros_msgs/State`.
    State {
        header: Header, connected: bool, armed: bool, guided: bool, manual_input: bool, mode: String, system_status: u8,
    }
    /// `mavros_msgs/VfrHud`.
    VfrHud {
        header: Header, airspeed: f32, groundspeed: f32, heading: i16, throttle: f32, altitude: f32, climb: f32,
    }
    /// `mavros_msgs/Waypoint`: an item of a mission as on the wire; degrees and m where it has a place, NaN for what is
    /// not set.
    Waypoint {
        frame: u8, command: u16, is_current: bool, autocontinue: bool, param1: f32, param2: f32, param3: f32, param4: f32,
        x_lat: f64, y_long: f64, z_alt: f64,
    }
    /// `mavros_msgs/WaypointList`.
    WaypointList { current_seq: u16, waypoints: Vec<Waypoint> }
    /// `mavros_msgs/HomePosition`; a `Point` has the fields of a vector.
    HomePosition { header: Header, geo: GeoPoint, position: Vector3, orientation: Quaternion, approach: Vector3 }
    /// `mavros_msgs/StatusText`: a `MAV_SEVERITY`, and the text.
    StatusText { header: Header, severity: u8, text: String }
    /// `mavros_msgs/ExtendedState`: a `MAV_VTOL_STATE` and a `MAV_LANDED_STATE`.
    ExtendedState { header: Header, vtol_state: u8, landed_state: u8 }
    /// `mavros_msgs/WaypointReached`: its number on the wire.
    WaypointReached { header: Header, wp_seq: u16 }
    /// `mavros_msgs/RCIn`: pulse lengths, µs.
    RCIn { header: Header, rssi: u8, channels: Vec<u16> }
    /// What asks without saying anything has a byte in its place.
    Empty { structure_needs_at_least_one_member: u8 }
    /// `std_srvs/SetBool_Request`.
    Switch { data: bool }
    /// `std_srvs/SetBool_Response`, `std_srvs/Trigger_Response`.
    Told { success: bool, message: String }
    /// `mavros_msgs/SetMode_Request`.
    ModeWanted { base_mode: u8, custom_mode: String }
    /// `mavros_msgs/SetMode_Response`.
    ModeSent { mode_sent: bool }
    /// `mavros_msgs/CommandBool_Response` and those of the other commands; the result is a `MAV_RESULT`.
    Commanded { success: bool, result: u8 }
    /// `mavros_msgs/CommandTOL_Request`.
    CommandedPlace { min_pitch: f32, yaw: f32, latitude: f32, longitude: f32, altitude: f32 }
    /// `mavros_msgs/CommandHome_Request`.
    HomeWanted { current_gps: bool, yaw: f32, latitude: f32, longitude: f32, altitude: f32 }
    /// `mavros_msgs/CommandLong_Request`.
    LongWanted {
        broadcast: bool, command: u16, confirmation: u8, param1: f32, param2: f32, param3: f32, param4: f32, param5: f32,
        param6: f32, param7: f32,
    }
    /// `mavros_msgs/WaypointSetCurrent_Request`.
    CurrentWanted { wp_seq: u16 }
    /// `mavros_msgs/WaypointClear_Response`, `mavros_msgs/WaypointSetCurrent_Response`.
    Succeeded { success: bool }
    /// `rcl_interfaces/ParameterValue`: the field that its type names counts.
    ParameterValue {
        r#type: u8, bool_value: bool, integer_value: i64, double_value: f64, string_value: String,
        byte_array_value: Vec<u8>, bool_array_value: Vec<bool>, integer_array_value: Vec<i64>,
        double_array_value: Vec<f64>, string_array_value: Vec<String>,
    }
    /// `rcl_interfaces/Parameter`.
    Parameter { name: String, value: ParameterValue }
    /// `rcl_interfaces/FloatingPointRange`.
    FloatingPointRange { from_value: f64, to_value: f64, step: f64 }
    /// `rcl_interfaces/IntegerRange`.
    IntegerRange { from_value: i64, to_value: i64, step: u64 }
    /// `rcl_interfaces/ParameterDescriptor`; of each range there is one at most.
    ParameterDescriptor {
        name: String, r#type: u8, description: String, additional_constraints: String, read_only: bool,
        dynamic_typing: bool, floating_point_range: Vec<FloatingPointRange>, integer_range: Vec<IntegerRange>,
    }
    /// `rcl_interfaces/SetParametersResult`.
    SetParametersResult { successful: bool, reason: String }
    /// `rcl_interfaces/ListParametersResult`.
    ListParametersResult { names: Vec<String>, prefixes: Vec<String> }
    /// `rcl_interfaces/GetParameters_Request` and those that ask for types and descriptions.
    NamesWanted { names: Vec<String> }
    /// `rcl_interfaces/GetParameters_Response`.
    Values { values: Vec<ParameterValue> }
    /// `rcl_interfaces/GetParameterTypes_Response`.
    Kinds { types: Vec<u8> }
    /// `rcl_interfaces/DescribeParameters_Response`.
    Descriptors { descriptors: Vec<ParameterDescriptor> }
    /// `rcl_interfaces/ListParameters_Request`.
    ListWanted { prefixes: Vec<String>, depth: u64 }
    /// `rcl_interfaces/ListParameters_Response`.
    Listed { result: ListParametersResult }
    /// `rcl_interfaces/SetParameters_Request`, `rcl_interfaces/SetParametersAtomically_Request`.
    ParametersWanted { parameters: Vec<Parameter> }
    /// `rcl_interfaces/SetParameters_Response`.
    SetResults { results: Vec<SetParametersResult> }
    /// `rcl_interfaces/SetParametersAtomically_Response`.
    SetAtOnce { result: SetParametersResult }
    /// `mavros_msgs/ParamPull_Request`.
    ParamPullWanted { force_pull: bool }
    /// `mavros_msgs/ParamPull_Response`.
    ParamPulled { success: bool, param_received: u32 }
    /// `mavros_msgs/ParamSetV2_Request`.
    ParamSetWanted { force_set: bool, param_id: String, value: ParameterValue }
    /// `mavros_msgs/ParamSetV2_Response`.
    ParamWritten { success: bool, value: ParameterValue }
    /// `mavros_msgs/WaypointPull_Response`.
    Pulled { success: bool, wp_received: u32 }
    /// `mavros_msgs/WaypointPush_Request`.
    MissionPushed { start_index: u16, waypoints: Vec<Waypoint> }
    /// `mavros_msgs/WaypointPush_Response`; spelled as there.
    Pushed { success: bool, wp_transfered: u32 }
}

messages! {
    Time = "builtin_interfaces" / "b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197";
    PoseStamped = "geometry_msgs" / "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8";
    TwistStamped = "geometry_msgs" / "5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64";
    TwistWithCovarianceStamped = "geometry_msgs" / "77b67434531e6529b7a0091357b186b6ebdb17fd9ffd3e0c7ce9d3fb11a44563";
    TFMessage = "tf2_msgs" / "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087";
    Odometry = "nav_msgs" / "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0";
    Path = "nav_msgs" / "1957a5bb3cee5da65c4e52e52b65a93df227efce4c20f8458b36e73066ca334b";
    NavSatFix = "sensor_msgs" / "62223ab3fe210a15976021da7afddc9e200dc9ec75231c1b6a557fc598a65404";
    Imu = "sensor_msgs" / "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b";
    BatteryState = "sensor_msgs" / "4bee5dfce981c98faa6828b868307a0a73f992ed0789f374ee96c8f840e69741";
    TimeReference = "sensor_msgs" / "dd66e84cf40bbb5d5a40472e6ecf2675a031334d4c426abdb2ad41801a8efc99";
    DiagnosticArray = "diagnostic_msgs" / "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e";
    Float64 = "std_msgs" / "705ba9c3d1a09df43737eb67095534de36fd426c0587779bda2bc51fe790182a";
    Log = "rcl_interfaces" / "e28ce254ca8abc06abf92773b74602cdbf116ed34fbaf294fb9f81da9f318eac";
    GeoPoseStamped = "geographic_msgs" / "a8e603c050fa992a74283bb462a96fe9d2b151b7a67b14d77250ed7cb4ed96b7";
    State = "mavros_msgs" / "11ba7686163d22281871f1cb42557e8957407469b0be813bdb1a8922c66e3131";
    VfrHud = "mavros_msgs" / "8a121968bf046a1f0f3e5074c8fed9db9ca5b6a8c0a2ee44c09c0f6a5fb88e8f";
    WaypointList = "mavros_msgs" / "fdd46486d81956d4d9700fd279bcdffb599465f7fed3351a24f34b9ab721aeaf";
    HomePosition = "mavros_msgs" / "d53f380680238e023e7fb96440b9094c55caa32c010629893eb51c1ee73e81d8";
    StatusText = "mavros_msgs" / "d3420a07bd2d933d9c53b51d04ec59dc61a0ed04c7110a51996795a3cfde68b2";
    ExtendedState = "mavros_msgs" / "19ff8d10f52aacba28d9879707d3195c9a9eff3af1ba2f7e40b55eea734e7b20";
    WaypointReached = "mavros_msgs" / "fe8d859bbb67edffb007b4047ca56da9f12f86d72c32b79acc0e1cbfd6fa2463";
    RCIn = "mavros_msgs" / "3dcc8e91d63f42d512ed29e767fc89fba216634f354c42467163a2b6f68f857e";
}

services! {
    /// Switches something on or off.
    SetBool: Switch => Told = "std_srvs" / "abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a";
    /// Has something done.
    Trigger: Empty => Told = "std_srvs" / "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f";
    /// Changes the mode.
    SetMode: ModeWanted => ModeSent = "mavros_msgs" / "16fc7ce085f4d07d5dd677238b42ef922d2a8aef71fabe6ad18b2ea52c9124da";
    /// Arms or disarms.
    CommandBool: Bool => Commanded = "mavros_msgs" / "eba73829da4af65d1019131d82f8eccae15d38717bf21409ed5187dd9bae73dc";
    /// Removes the mission.
    WaypointClear: Empty => Succeeded = "mavros_msgs" / "d77b775b7112320e4824747838a0a1412e9288e66cb14acbc581c3b84c22df6d";
    /// Reads the mission.
    WaypointPull: Empty => Pulled = "mavros_msgs" / "dba4ca9a44272d78ca9c6c0e0bbb8fdeb898b5bba9fbf2d47e6547cba7f7492a";
    /// Replaces the mission, or some of its waypoints.
    WaypointPush: MissionPushed => Pushed = "mavros_msgs" / "280a0e2e40640f42c7bf28acc7e77ff58e89f8e767fb100f342f4e1a6ddc4350";
    /// Reads all parameters.
    ParamPull: ParamPullWanted => ParamPulled = "mavros_msgs" / "bd1d82d05a5fd7ceef3b7a1fa63e4122325733d578ce193395946f69fd5ec7e1";
    /// Writes a parameter.
    ParamSetV2: ParamSetWanted => ParamWritten = "mavros_msgs" / "e0335a4038c2ca9b28f9427764bc56cc32b25148ef0e83cc9fd2cd4128801bc9";
    /// Reads parameters.
    GetParameters: NamesWanted => Values = "rcl_interfaces" / "bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc";
    /// Tells the types of parameters.
    GetParameterTypes: NamesWanted => Kinds = "rcl_interfaces" / "da199c878688b3e530bdfe3ca8f74cb9fa0c303101e980a9e8f260e25e1c80ca";
    /// Describes parameters.
    DescribeParameters: NamesWanted => Descriptors = "rcl_interfaces" / "845b484d71eb0673dae682f2e3ba3c4851a65a3dcfb97bddd82c5b57e91e4cff";
    /// Lists parameters.
    ListParameters: ListWanted => Listed = "rcl_interfaces" / "3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d";
    /// Writes parameters, each by itself.
    SetParameters: ParametersWanted => SetResults = "rcl_interfaces" / "56eed9a67e169f9cb6c1f987bc88f868c14a8fc9f743a263bc734c154015d7e0";
    /// Writes parameters, all or none.
    SetParametersAtomically: ParametersWanted => SetAtOnce = "rcl_interfaces" / "0e192ef259c07fc3c07a13191d27002222e65e00ccec653ca05e856f79285fcd";
    /// Makes a waypoint the current one.
    WaypointSetCurrent: CurrentWanted => Succeeded = "mavros_msgs" / "9c640038e67868f5d9f8da4605de07ed8314e1e767438c74ddc9bbc0fd8b65a1";
    /// Takes off, or lands.
    CommandTOL: CommandedPlace => Commanded = "mavros_msgs" / "03faac8deec2f89820ff196f8835713a58692713cb164cea25a0022c2b8e4ffe";
    /// Moves home.
    CommandHome: HomeWanted => Commanded = "mavros_msgs" / "99b59d7d17a81b8a5fde31b15d2e5e97e2480b211a22851d11592204d08b99ea";
    /// Any command.
    CommandLong: LongWanted => Commanded = "mavros_msgs" / "4eba263db07465d64c8b51c68b29d0e649c6761043838cc701b226bc9a813214";
}

/// `mavros_msgs/CommandBool_Request`, which has the form of a switch.
pub type Bool = Switch;

#[cfg(test)]
mod tests {
    use rand::rngs::StdRng;
    use rand::{Rng, SeedableRng};

    use super::*;

    /// Random bytes that are a message are the same message when they were written and read again; the others are
    /// refused, and nothing falls over. How many there were that could be read.
    fn survives<T: Cdr>(random: &mut StdRng) -> u32 {
        let mut read = 0;
        for _ in 0..300 {
            let length = random.random_range(0..800);
            // Mostly zeros: lengths that are not too long, strings that end.
            let body = (0..length).map(|_| if random.random_bool(0.9) { 0 } else { random.random() });
            let bytes: Vec<u8> = [0, 1, 0, 0].into_iter().chain(body).collect();
            let Ok(message) = T::from_bytes(&bytes) else { continue };
            read += 1;
            let written = message.to_bytes();
            let again = T::from_bytes(&written).expect("what we write can be read");
            // By their bytes, as no NaN equals itself.
            assert_eq!(again.to_bytes(), written);
            for cut in 0..written.len().saturating_sub(1) {
                assert!(T::from_bytes(&written[..cut]).is_err(), "{cut} of {}", written.len());
            }
        }
        read
    }

    #[test]
    fn each_message_comes_back_as_it_was_and_half_a_one_never() {
        let mut random = StdRng::seed_from_u64(26);
        let mut all = 0;
        macro_rules! each {
            ($($name:ident),*) => {$(
                let read = survives::<$name>(&mut random);
                assert!(read > 0, "none of {}", stringify!($name));
                all += read;
            )*};
        }
        each!(
            Time,
            PoseStamped,
            TwistStamped,
            TwistWithCovarianceStamped,
            TFMessage,
            Odometry,
            Path,
            NavSatFix,
            Imu,
            BatteryState,
            TimeReference,
            DiagnosticArray,
            Float64,
            Log,
            GeoPoseStamped,
            State,
            VfrHud,
            WaypointList,
            HomePosition,
            StatusText,
            ExtendedState,
            WaypointReached,
            RCIn,
            CommandedPlace,
            HomeWanted,
            LongWanted,
            ParameterDescriptor,
            NamesWanted,
            Values,
            Kinds,
            Descriptors,
            ListWanted,
            Listed,
            ParametersWanted,
            SetResults,
            SetAtOnce,
            ParamPullWanted,
            ParamPulled,
            ParamSetWanted,
            ParamWritten,
            CurrentWanted,
            Succeeded,
            Switch,
            Told,
            ModeWanted,
            Commanded,
            Pulled,
            MissionPushed,
            Pushed
        );
        assert!(all > 1000, "{all}");
    }
}
