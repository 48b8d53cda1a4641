//! Telemetry as front doors report it: each group with its age, what changed since a client heard it last, and the
//! schema of both.

use std::borrow::Cow;

use serde::{Serialize, Serializer};
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, OneOfBuilder, RefBuilder, Schema, Type};
use utoipa::openapi::{KnownFormat, RefOr, SchemaFormat};
use utoipa::{PartialSchema, ToSchema};
use vencejo_proto::MonoTime;

use super::groups::*;
use super::{Home, MAX_BATTERIES, MAX_IMUS, Sampled, Telemetry, for_each_group};

/// A group at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Aged<T> {
    /// How old the values are.
    pub age_s: f64,
    /// Whether the message held a value that cannot be; such fields are `None`.
    pub has_invalid: bool,
    /// The values.
    #[serde(flatten)]
    pub value: T,
}

impl<T: Copy> Sampled<T> {
    /// The group as it is at `now`.
    fn aged(&self, now: MonoTime) -> Aged<T> {
        Aged { age_s: self.age(now).as_secs_f64(), has_invalid: self.invalid, value: self.value }
    }
}

/// The schema of `Aged<T>`: the group's, with age and validity before its own fields.
fn aged_schema<T: ToSchema>() -> RefOr<Schema> {
    let RefOr::T(Schema::Object(mut group)) = T::schema() else { return T::schema() };
    for schema in group.properties.values_mut() {
        let description = match schema {
            RefOr::T(Schema::Object(field)) => &mut field.description,
            RefOr::T(Schema::Array(field)) => &mut field.description,
            _ => continue,
        };
        // Rust says it in its own word.
        *description = description.take().map(|about| about.replace("`None`", "null"));
    }
    let age =
        ObjectBuilder::new().schema_type(Type::Number).format(Some(SchemaFormat::KnownFormat(KnownFormat::Double)));
    let has_invalid = ObjectBuilder::new().schema_type(Type::Boolean);
    let common = [
        ("age_s", age.description(Some("How old the values are, seconds."))),
        (
            "has_invalid",
            has_invalid.description(Some("Whether the message held a value that cannot be; such fields are null.")),
        ),
    ];
    group.required.splice(0..0, common.iter().map(|(name, _)| (*name).to_owned()));
    group.properties.extend(common.map(|(name, schema)| (name.to_owned(), schema.into())));
    group.additional_properties = None;
    Schema::Object(group).into()
}

/// A group of this name, or null.
fn or_null(name: &str, about: Option<&str>) -> OneOfBuilder {
    let group = RefBuilder::new().ref_location_from_schema_name(name).description(about);
    OneOfBuilder::new().item(group).item(ObjectBuilder::new().schema_type(Type::Null))
}

/// `None` is left out of the JSON ("as before"), `Some(None)` is null ("forgotten").
type Slot<T> = Option<Option<Aged<T>>>;

macro_rules! title {
    ($value:ident) => {
        stringify!($value)
    };
    ($value:ident $title:literal) => {
        $title
    };
}

macro_rules! report {
    (reported { $($(#[doc = $doc:literal])* $field:ident: $value:ident $(as $title:literal)?,)* } kept $kept:tt) => {
        /// The newest values by group. A group that was never heard is absent. In a WebSocket message a group that did
        /// not change is absent, and one that the vehicle's restart made void is null.
        #[derive(Debug, Clone, PartialEq, Serialize, Default)]
        pub struct TelemetryGroups {
            $($(#[doc = $doc])*
            #[serde(skip_serializing_if = "Option::is_none")]
            pub $field: Slot<$value>,)*
            /// The first inertial sensor; the same as the first of `imus`.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub imu: Slot<Imu>,
            /// Inertial sensors 1 to 3.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub imus: Option<[Option<Aged<Imu>>; MAX_IMUS]>,
            /// The batteries heard so far.
            #[serde(skip_serializing_if = "Option::is_none")]
            pub batteries: Option<Vec<Aged<Battery>>>,
        }

        /// When each group was sent last; what a client that reads slowly has still to hear follows from it.
        #[derive(Debug, Clone, PartialEq, Default)]
        pub struct Sent {
            $($field: Option<MonoTime>,)*
            imus: [Option<MonoTime>; MAX_IMUS],
            batteries: [Option<MonoTime>; MAX_BATTERIES],
        }

        impl TelemetryGroups {
            /// What `telemetry` has that was not sent yet; `sent` is brought up to it.
            pub fn changes(telemetry: &Telemetry, now: MonoTime, sent: &mut Sent) -> Self {
                let mut groups = Self::default();
                $({
                    let at = telemetry.$field.as_ref().map(|sampled| sampled.at);
                    if at != sent.$field {
                        sent.$field = at;
                        groups.$field = Some(telemetry.$field.as_ref().map(|sampled| sampled.aged(now)));
                    }
                })*
                let moments = telemetry.imus.map(|imu| imu.map(|sampled| sampled.at));
                if moments != sent.imus {
                    let imus = telemetry.imus_at(now);
                    if moments[0] != sent.imus[0] {
                        groups.imu = Some(imus[0]);
                    }
                    groups.imus = Some(imus);
                    sent.imus = moments;
                }
                let moments = telemetry.batteries.map(|battery| battery.map(|sampled| sampled.at));
                if moments != sent.batteries {
                    groups.batteries = Some(telemetry.batteries_at(now).collect());
                    sent.batteries = moments;
                }
                groups
            }

            /// Everything that `telemetry` has.
            pub fn all(telemetry: &Telemetry, now: MonoTime) -> Self {
                Self::changes(telemetry, now, &mut Sent::default())
            }

            /// Whether there is nothing to report.
            pub fn is_empty(&self) -> bool {
                $(self.$field.is_none() &&)* self.imus.is_none() && self.batteries.is_none()
            }
        }

        impl PartialSchema for TelemetryGroups {
            fn schema() -> RefOr<Schema> {
                let imus = ArrayBuilder::new().items(or_null("Imu", None));
                let battery = RefBuilder::new().ref_location_from_schema_name("Battery");
                let about = "The newest values by group. A group that was never heard is absent. In a WebSocket message a group that \
                             did not\nchange is absent, and one that the vehicle's restart made void is null.";
                let groups = ObjectBuilder::new()
                    $(.property(
                        stringify!($field),
                        or_null(title!($value $($title)?), Some([$($doc.trim()),*].join("\n").as_str())),
                    ))*
                    .property("imu", or_null("Imu", Some("The first inertial sensor; the same as the first of `imus`.")))
                    .property("imus", imus.description(Some("Inertial sensors 1 to 3.")))
                    .property("batteries", ArrayBuilder::new().items(battery).description(Some("The batteries heard so far.")));
                groups.description(Some(about)).into()
            }
        }

        impl ToSchema for TelemetryGroups {
            fn name() -> Cow<'static, str> {
                Cow::Borrowed("TelemetryGroups")
            }

            fn schemas(schemas: &mut Vec<(String, RefOr<Schema>)>) {
                $(schemas.push((title!($value $($title)?).to_owned(), aged_schema::<$value>()));)*
                schemas.push(("Imu".to_owned(), aged_schema::<Imu>()));
                schemas.push(("Battery".to_owned(), aged_schema::<Battery>()));
            }
        }

        impl Telemetry {
            /// Writes the group of this name, as it is at `now`, with `serializer`: "none" when it was not heard.
            /// `None` when no group has this name.
            pub fn serialize_group<S: Serializer>(&self, name: &str, now: MonoTime, serializer: S) -> Option<Result<S::Ok, S::Error>> {
                Some(match name {
                    $(stringify!($field) => self.$field.map(|sampled| sampled.aged(now)).serialize(serializer),)*
                    "imu" => self.imus_at(now)[0].serialize(serializer),
                    "imus" => self.imus_at(now).serialize(serializer),
                    "batteries" => serializer.collect_seq(self.batteries_at(now)),
                    _ => return None,
                })
            }

            fn imus_at(&self, now: MonoTime) -> [Option<Aged<Imu>>; MAX_IMUS] {
                self.imus.map(|imu| imu.map(|sampled| sampled.aged(now)))
            }

            fn batteries_at(&self, now: MonoTime) -> impl Iterator<Item = Aged<Battery>> {
                self.batteries.iter().flatten().map(move |sampled| sampled.aged(now))
            }
        }
    };
}

for_each_group!(report);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::testing::{PLANE, recorded};

    fn sampled<T>(value: T, ms: u64) -> Option<Sampled<T>> {
        Some(Sampled { value, at: MonoTime::from_millis(ms), invalid: false })
    }

    #[test]
    fn only_what_changed_is_reported_and_what_is_void_is_null() {
        let now = MonoTime::from_millis(200);
        let mut sent = Sent::default();
        let mut telemetry = Telemetry {
            attitude: sampled(Attitude { roll_rad: Some(0.1), ..Attitude::default() }, 100),
            wind: sampled(Wind::default(), 100),
            ..Telemetry::default()
        };
        telemetry.imus[0] = sampled(Imu::default(), 100);
        let json = |groups: &TelemetryGroups| serde_json::to_value(groups).expect("JSON");

        let first = TelemetryGroups::changes(&telemetry, now, &mut sent);
        let first = json(&first);
        let keys: Vec<_> = first.as_object().expect("an object").keys().cloned().collect();
        assert_eq!(keys, ["attitude", "imu", "imus", "wind"]);
        assert_eq!(first["attitude"]["roll_rad"], 0.1);
        assert_eq!(first["attitude"]["age_s"], 0.1);
        assert!(first["attitude"]["pitch_rad"].is_null(), "an absent value is null, and its key is there");

        assert!(TelemetryGroups::changes(&telemetry, now, &mut sent).is_empty());

        telemetry.wind = None;
        telemetry.attitude = sampled(Attitude::default(), 150);
        let second = json(&TelemetryGroups::changes(&telemetry, now, &mut sent));
        assert!(second["wind"].is_null() && second.get("wind").is_some());
        assert_eq!(second.as_object().expect("an object").len(), 2);
    }

    /// Schemas are put together from two parts: what they require is what is sent.
    #[test]
    fn every_group_has_the_fields_of_its_schema() {
        let mut telemetry = Telemetry::new();
        for (at, message) in recorded("arduplane-takeoff-to-landing", PLANE) {
            telemetry.apply(&message, at);
        }
        let groups = serde_json::to_value(TelemetryGroups::all(&telemetry, MonoTime::ZERO)).expect("JSON");
        let groups = groups.as_object().expect("an object");
        let schema = serde_json::to_value(TelemetryGroups::schema()).expect("JSON");
        let mut schemas = Vec::new();
        TelemetryGroups::schemas(&mut schemas);
        let mut compared = 0;
        for (name, group) in groups.iter().filter(|(_, group)| group.is_object()) {
            let title = schema["properties"][name]["oneOf"][0]["$ref"].as_str().expect("a reference");
            let title = title.rsplit('/').next().expect("a name");
            let (_, schema) = schemas.iter().find(|(schema, _)| schema == title).expect("described");
            let mut required: Vec<String> =
                serde_json::from_value(serde_json::to_value(schema).expect("JSON")["required"].clone()).expect("names");
            required.sort();
            let fields: Vec<_> = group.as_object().expect("an object").keys().cloned().collect();
            assert_eq!(fields, required, "{name}");
            compared += 1;
        }
        assert!(compared > 14, "{compared}");
    }
}
