//! Somebody of ROS 2 who is not ours, by `hiroz`: `HIROZ_MSG_PATH=FOLDER ros2-hiroz PORT`, asked by lines of JSON (`tests/fleet/ros2_lines.py`).
//!
//! It works out keys, hashes and tokens by itself, and reads CDR: the types that it brings along as Rust structures made from ROS 2's
//! definitions, the others by definitions in the folder. Of a number that is none JSON has null.

use std::collections::BTreeMap;
use std::io::{self, BufRead as _, Write as _};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use hiroz::context::{ZContext, ZContextBuilder};
use hiroz::dynamic::{DynamicMessage, DynamicValue, load_schema, ros_type_name_from_dds};
use hiroz::node::ZNode;
use hiroz::{Builder as _, Result};
use hiroz_msgs::std_srvs::srv::{SetBool, Trigger};
use hiroz_msgs::{builtin_interfaces, diagnostic_msgs, geometry_msgs, nav_msgs, sensor_msgs, std_msgs, tf2_msgs};
use serde_json::{Value, json};
use tokio::runtime::Runtime;

/// A wait longer than this is a failure.
const PATIENCE: Duration = Duration::from_secs(60);

/// A topic of a domain.
type Topic = (usize, String);

/// The first message of each topic that was heard, and who waits for it.
#[derive(Default)]
struct Heard {
    messages: Mutex<BTreeMap<Topic, Value>>,
    more: Condvar,
}

impl Heard {
    fn note(&self, topic: &Topic, message: Value) {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        messages.entry(topic.clone()).or_insert(message);
        self.more.notify_all();
    }

    fn wait(&self, topic: &Topic) -> Result<Value> {
        let messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        let (messages, _) = self
            .more
            .wait_timeout_while(messages, PATIENCE, |messages| !messages.contains_key(topic))
            .unwrap_or_else(PoisonError::into_inner);
        Ok(messages.get(topic).ok_or_else(|| format!("nothing heard of {topic:?}"))?.clone())
    }
}

/// A node in each domain that is asked about.
struct Peer {
    router: String,
    nodes: BTreeMap<usize, (ZContext, ZNode)>,
    heard: Arc<Heard>,
    runtime: Runtime,
}

impl Peer {
    fn node(&mut self, domain: usize) -> Result<&ZNode> {
        if !self.nodes.contains_key(&domain) {
            let context = ZContextBuilder::default()
                .with_domain_id(domain)
                .with_mode("client")
                .with_connect_endpoints([&*self.router])
                .disable_multicast_scouting()
                .build()?;
            let node = context.create_node("hiroz").without_parameters().build()?;
            self.nodes.insert(domain, (context, node));
        }
        Ok(&self.nodes[&domain].1)
    }

    /// Does one thing.
    fn answer(&mut self, asked: &Value) -> Result<Value> {
        let domain: usize = serde_json::from_value(asked["domain"].clone())?;
        match asked["do"].as_str() {
            Some("listed") => {
                let graph = self.node(domain)?.graph();
                let named = |found: Vec<(String, String)>| -> BTreeMap<String, String> {
                    found.into_iter().map(|(name, kind)| (name, ros_type_name_from_dds(&kind))).collect()
                };
                Ok(json!([named(graph.get_topic_names_and_types()), named(graph.get_service_names_and_types())]))
            }
            Some("listen") => {
                let topics: BTreeMap<String, String> = serde_json::from_value(asked["topics"].clone())?;
                for (name, kind) in &topics {
                    self.listen(domain, name, kind)?;
                }
                Ok(Value::Null)
            }
            Some("heard") => {
                let names: Vec<String> = serde_json::from_value(asked["names"].clone())?;
                names.into_iter().map(|name| Ok((name.clone(), self.heard.wait(&(domain, name))?))).collect()
            }
            Some("call") => {
                let text = |field: &str| asked[field].as_str().unwrap_or_default().to_owned();
                self.call(domain, &text("name"), &text("kind"), &asked["request"])
            }
            other => Err(format!("{other:?} is not done here").into()),
        }
    }

    fn listen(&mut self, domain: usize, name: &str, kind: &str) -> Result<()> {
        let (heard, noted) = (self.heard.clone(), (domain, name.to_owned()));
        let node = self.node(domain)?;
        // Each in a thread of its own; what it cannot read ends the program.
        macro_rules! by_type {
            ($($known:literal => $type:ty),* $(,)?) => {
                match kind {
                    $($known => {
                        let topic = node.create_sub::<$type>(name).build()?;
                        std::thread::spawn(move || loop {
                            heard.note(&noted, json!(read(topic.recv(), &noted)));
                        });
                    })*
                    _ => {
                        let schema = load_schema(kind).ok_or_else(|| format!("no definition of {kind} below HIROZ_MSG_PATH"))?;
                        let topic = node.create_dyn_sub(name, schema).build()?;
                        std::thread::spawn(move || loop {
                            heard.note(&noted, plain_message(&read(topic.recv(), &noted)));
                        });
                    }
                }
            };
        }
        by_type! {
            "builtin_interfaces/msg/Time" => builtin_interfaces::Time,
            "diagnostic_msgs/msg/DiagnosticArray" => diagnostic_msgs::DiagnosticArray,
            "geometry_msgs/msg/PoseStamped" => geometry_msgs::PoseStamped,
            "geometry_msgs/msg/TwistStamped" => geometry_msgs::TwistStamped,
            "geometry_msgs/msg/TwistWithCovarianceStamped" => geometry_msgs::TwistWithCovarianceStamped,
            "nav_msgs/msg/Odometry" => nav_msgs::Odometry,
            "nav_msgs/msg/Path" => nav_msgs::Path,
            "sensor_msgs/msg/BatteryState" => sensor_msgs::BatteryState,
            "sensor_msgs/msg/Imu" => sensor_msgs::Imu,
            "sensor_msgs/msg/NavSatFix" => sensor_msgs::NavSatFix,
            "sensor_msgs/msg/TimeReference" => sensor_msgs::TimeReference,
            "std_msgs/msg/Float64" => std_msgs::Float64,
            "tf2_msgs/msg/TFMessage" => tf2_msgs::TFMessage,
        }
        Ok(())
    }

    /// The answer of a service whose type it brings along.
    fn call(&mut self, domain: usize, name: &str, kind: &str, request: &Value) -> Result<Value> {
        self.node(domain)?;
        let node = &self.nodes[&domain].1;
        macro_rules! by_type {
            ($($known:literal => $type:ty),* $(,)?) => {
                match kind {
                    $($known => {
                        let request = serde_json::from_value(request.clone())?;
                        self.runtime.block_on(async {
                            let client = node.create_client::<$type>(name).build()?;
                            Ok(json!(client.call_with_timeout(&request, PATIENCE).await?))
                        })
                    })*
                    _ => Err(format!("no service of type {kind} here").into()),
                }
            };
        }
        by_type! { "std_srvs/srv/SetBool" => SetBool, "std_srvs/srv/Trigger" => Trigger }
    }
}

fn read<T>(message: Result<T>, topic: &Topic) -> T {
    message.unwrap_or_else(|error| {
        eprintln!("{topic:?} cannot be read: {error}");
        std::process::exit(1)
    })
}

fn plain_message(message: &DynamicMessage) -> Value {
    message.iter().map(|(name, value)| (name.to_owned(), plain(value))).collect()
}

fn plain(value: &DynamicValue) -> Value {
    match value {
        DynamicValue::Bool(value) => json!(value),
        DynamicValue::Int8(value) => json!(value),
        DynamicValue::Int16(value) => json!(value),
        DynamicValue::Int32(value) => json!(value),
        DynamicValue::Int64(value) => json!(value),
        DynamicValue::Uint8(value) => json!(value),
        DynamicValue::Uint16(value) => json!(value),
        DynamicValue::Uint32(value) => json!(value),
        DynamicValue::Uint64(value) => json!(value),
        DynamicValue::Float32(value) => json!(value),
        DynamicValue::Float64(value) => json!(value),
        DynamicValue::String(value) => json!(value),
        DynamicValue::Bytes(value) => json!(value),
        DynamicValue::Message(message) => plain_message(message),
        DynamicValue::Array(values) => values.iter().map(plain).collect(),
    }
}

fn main() -> Result<()> {
    let port = std::env::args().nth(1).ok_or("ros2-hiroz PORT")?;
    let mut peer = Peer {
        router: format!("tcp/127.0.0.1:{port}"),
        nodes: BTreeMap::new(),
        heard: Arc::default(),
        runtime: Runtime::new()?,
    };
    let say = |answer: Value| writeln!(io::stdout(), "{answer}");
    say(json!("ready"))?;
    for line in io::stdin().lock().lines() {
        say(peer.answer(&serde_json::from_str(&line?)?)?)?;
    }
    Ok(())
}
