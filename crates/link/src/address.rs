//! Owns link strings: one parser for every spelling that the MAVLink family uses, and the canonical spelling of each.
//!
//! | family | accepted |
//! |---|---|
//! | pymavlink, MAVProxy, DroneKit | `udp:` `udpin:` `udpout:` `udpbcast:` `tcp:` `tcpin:` + `host:port`; `/dev/ttyACM0[,57600]`, `com14`; bare `127.0.0.1:14550`; a file that ends in `.tlog` |
//! | MAVSDK | `udpin://` `udpout://` `tcpin://` `tcpout://` `serial:///dev/ttyUSB0:57600`; old `udp://:14540` |
//! | MAVROS | `udp://[bind]:14555@[host]:14550`, `tcp://`, `tcp-l://`, `serial:///dev/x:57600?ids=s,c` |
//! | mavlink-server | `udpserver://` `udpclient://` `tcpserver://` `tcpclient://` `tlogreader://` |
//!
//! What may be left out: the port (UDP 14550, TCP 5760), the host of a listening UDP link (`0.0.0.0`, so that aircraft
//! reach it; `lan` accepts this machine and private networks only), the host of a TCP server (`127.0.0.1`: open to the
//! network only on request) and the baud rate (115200 for a USB device such as `ttyACM0`, otherwise 57600, the rate of
//! telemetry radios).

mod forms;
mod parser;

use std::fmt;
use std::str::FromStr;

pub use forms::{
    AddressError, DEFAULT_BAUD, DEFAULT_TCP_PORT, DEFAULT_UDP_PORT, DEFAULT_USB_BAUD, HostPort, LinkAddress,
};
use parser::Parser;
pub(crate) use parser::default_baud;
use vencejo_proto::Address;

impl LinkAddress {
    /// Reads a link string, and with it the system and component id that MAVROS' `?ids=s,c` asks us to take.
    ///
    /// # Errors
    /// [`AddressError`] says what is wrong and shows the right form.
    pub fn parse_with_ids(text: &str) -> Result<(Self, Option<Address>), AddressError> {
        Parser { text: text.trim() }.parse()
    }

    /// Whether only this machine and devices plugged into it can be at the other end: loopback, and an autopilot's own
    /// USB. Not a serial adapter, which mostly has a radio behind it.
    pub fn is_private(&self) -> bool {
        match self {
            Self::UdpIn { bind } | Self::TcpServer { bind } => bind.is_loopback(),
            Self::UdpOut { remote, bind } => remote.is_loopback() && bind.as_ref().is_none_or(HostPort::is_loopback),
            Self::TcpClient { remote } => remote.is_loopback(),
            Self::Serial { path, .. } => {
                // What `/dev/serial/by-id/…` stands for.
                let device = std::fs::canonicalize(path).unwrap_or_else(|_| path.into());
                let name = device.file_name().and_then(|name| name.to_str()).unwrap_or_default();
                ["ttyACM", "cu.usbmodem", "tty.usbmodem"].iter().any(|usb| name.starts_with(usb))
            }
            Self::UdpBroadcast { .. } => false,
            Self::Tlog { .. } => true,
        }
    }
}

impl FromStr for LinkAddress {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        Self::parse_with_ids(text).map(|(address, _)| address)
    }
}

impl fmt::Display for LinkAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UdpIn { bind } => write!(f, "udpin:{bind}"),
            Self::UdpOut { remote, bind: None } => write!(f, "udpout:{remote}"),
            Self::UdpOut { remote, bind: Some(bind) } => write!(f, "udp://{bind}@{remote}"),
            Self::UdpBroadcast { remote } => write!(f, "udpbcast:{remote}"),
            Self::TcpClient { remote } => write!(f, "tcp:{remote}"),
            Self::TcpServer { bind } => write!(f, "tcpin:{bind}"),
            Self::Serial { path, baud } => write!(f, "serial:{path}:{baud}"),
            Self::Tlog { path, speed, repeat } => {
                write!(f, "tlog:{}", path.display())?;
                match (*speed == 1.0, repeat) {
                    (true, false) => Ok(()),
                    (false, false) => write!(f, "?speed={speed}"),
                    (true, true) => f.write_str("?loop=true"),
                    (false, true) => write!(f, "?speed={speed}&loop=true"),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_of_the_family_is_read() {
        // given → canonical
        let cases = [
            ("udpin:0.0.0.0:14550", "udpin:0.0.0.0:14550"),
            ("udp:127.0.0.1:14551", "udpin:127.0.0.1:14551"),
            ("udp:", "udpin:0.0.0.0:14550"),
            ("udp::14540", "udpin:0.0.0.0:14540"),
            ("udpin:14540", "udpin:0.0.0.0:14540"),
            ("UDPIN:localhost:14550", "udpin:localhost:14550"),
            ("  udpin:0.0.0.0:14550\n", "udpin:0.0.0.0:14550"),
            ("udpout:192.168.1.20:14550", "udpout:192.168.1.20:14550"),
            ("udpout:gcs.example.org", "udpout:gcs.example.org:14550"),
            ("udpbcast:192.168.1.255:14550", "udpbcast:192.168.1.255:14550"),
            ("tcp:127.0.0.1:5760", "tcp:127.0.0.1:5760"),
            ("tcp:sitl", "tcp:sitl:5760"),
            ("tcpin:0.0.0.0:5770", "tcpin:0.0.0.0:5770"),
            ("tcpin:", "tcpin:127.0.0.1:5760"),
            ("127.0.0.1:14550", "udpin:127.0.0.1:14550"),
            ("localhost:14550", "udpin:localhost:14550"),
            (":14550", "udpin:0.0.0.0:14550"),
            ("/dev/ttyACM0", "serial:/dev/ttyACM0:115200"),
            ("/dev/ttyACM0,57600", "serial:/dev/ttyACM0:57600"),
            ("/dev/ttyUSB0:57600", "serial:/dev/ttyUSB0:57600"),
            ("/dev/ttyUSB0", "serial:/dev/ttyUSB0:57600"),
            (
                "/dev/serial/by-path/pci-0000:00:14.0-usb-0:2:1.0",
                "serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:2:1.0:57600",
            ),
            (
                "/dev/serial/by-id/usb-ArduPilot_CubeOrange_1-if00",
                "serial:/dev/serial/by-id/usb-ArduPilot_CubeOrange_1-if00:115200",
            ),
            ("com14", "serial:com14:57600"),
            ("COM3,115200", "serial:COM3:115200"),
            ("COM3:115200", "serial:COM3:115200"),
            // MAVSDK
            ("udpin://0.0.0.0:14540", "udpin:0.0.0.0:14540"),
            ("udpout://192.168.1.1:14550", "udpout:192.168.1.1:14550"),
            ("udp://:14540", "udpin:0.0.0.0:14540"),
            ("tcpin://0.0.0.0:5760", "tcpin:0.0.0.0:5760"),
            ("tcpout://10.0.0.1:5760", "tcp:10.0.0.1:5760"),
            ("serial:///dev/ttyUSB0:57600", "serial:/dev/ttyUSB0:57600"),
            ("serial:/dev/ttyS0:921600", "serial:/dev/ttyS0:921600"),
            ("serial:/dev/ttyS0?baud=9600", "serial:/dev/ttyS0:9600"),
            ("serial://COM3:57600", "serial:COM3:57600"),
            // MAVROS
            ("udp://127.0.0.1:14555@10.1.1.2:14550", "udp://127.0.0.1:14555@10.1.1.2:14550"),
            ("udp://:14540@", "udpin:0.0.0.0:14540"),
            ("udp://:14540@192.168.1.36:14557/?ids=255,240", "udp://0.0.0.0:14540@192.168.1.36:14557"),
            ("udp://@10.1.1.2", "udp://0.0.0.0:14550@10.1.1.2:14550"),
            ("tcp://127.0.0.1:5760", "tcp:127.0.0.1:5760"),
            ("tcp-l://:5760", "tcpin:127.0.0.1:5760"),
            ("serial:///dev/ttyUSB0:57600?ids=255,190", "serial:/dev/ttyUSB0:57600"),
            // mavlink-server
            ("udpserver://0.0.0.0:14550", "udpin:0.0.0.0:14550"),
            ("udpclient://127.0.0.1:14550", "udpout:127.0.0.1:14550"),
            ("tcpserver://0.0.0.0:5760", "tcpin:0.0.0.0:5760"),
            ("tcpclient://127.0.0.1:5760", "tcp:127.0.0.1:5760"),
            ("tlogreader:///tmp/a.tlog", "tlog:/tmp/a.tlog"),
            // recordings
            ("tlog:flight.tlog", "tlog:flight.tlog"),
            ("tlog:flight.tlog?speed=2", "tlog:flight.tlog?speed=2"),
            ("tlog:/a b/flight.bin?speed=0.5&loop", "tlog:/a b/flight.bin?speed=0.5&loop=true"),
            ("flights/one.tlog", "tlog:flights/one.tlog"),
            ("/tmp/one.tlog", "tlog:/tmp/one.tlog"),
            // IPv6
            ("udpin:[::]:14550", "udpin:[::]:14550"),
            ("[::1]:14550", "udpin:[::1]:14550"),
            ("tcp://[fe80::1%eth0]:5760", "tcp:[fe80::1%eth0]:5760"),
            ("udpout:[2001:db8::2]", "udpout:[2001:db8::2]:14550"),
            ("udp://[::1]:14540@[::1]:14557", "udp://[::1]:14540@[::1]:14557"),
        ];
        for (given, canonical) in cases {
            let address: LinkAddress = given.parse().unwrap_or_else(|error| panic!("{given}: {error}"));
            assert_eq!(address.to_string(), canonical, "{given}");
            assert_eq!(canonical.parse::<LinkAddress>().unwrap(), address, "{canonical} reads back as itself");
        }
    }

    #[test]
    fn ids_are_read() {
        let (_, ids) = LinkAddress::parse_with_ids("udp://:14540@10.0.0.2:14557/?ids=1,191").unwrap();
        assert_eq!(ids, Some(Address::new(1, 191)));
        assert_eq!(LinkAddress::parse_with_ids("udp:").unwrap().1, None);
    }

    #[test]
    fn errors_say_what_was_wrong_and_show_the_right_form() {
        // given, a part of the message
        let cases = [
            ("", "empty"),
            ("upd:127.0.0.1:14550", "did you mean `udp:127.0.0.1:14550`?"),
            ("updin:0.0.0.0:14550", "did you mean `udpin:0.0.0.0:14550`?"),
            ("tpc://127.0.0.1:5760", "did you mean `tcp:127.0.0.1:5760`?"),
            ("seral:/dev/ttyACM0", "did you mean `serial:/dev/ttyACM0`?"),
            ("udpserve://:14550", "did you mean `udpserver:"),
            ("ttyUSB0", "did you mean `/dev/ttyUSB0`?"),
            ("carrier-pigeon:home", "is not a kind of link; kinds are"),
            ("plane", "`plane` in `plane` is not a kind of link"),
            ("mcast:", "not supported"),
            ("udpout:", "names no host; write `udpout:127.0.0.1:14550`"),
            ("tcp:", "names no host; write `tcp:127.0.0.1:5760`"),
            ("tcp:host:0", "`0` in `tcp:host:0` is not a port from 1"),
            ("udpin:0.0.0.0:99999", "`99999` in `udpin:0.0.0.0:99999` is not a port from 0"),
            ("udpin:0.0.0.0:http", "not a port"),
            ("udpin:::1:14550", "IPv6 address goes in brackets"),
            ("udpin:[::1:14550", "not a host name or address"),
            ("tcp:ho st:5760", "`ho st`"),
            ("tcp:a:5760@b:5760", "not a host name or address"),
            ("/dev/ttyUSB0,fast", "`fast`"),
            ("/dev/ttyUSB0:57", "`57` in `/dev/ttyUSB0:57` is not a baud rate"),
            ("/dev/ttyUSB0:x", "not a baud rate"),
            ("serial:", "names no device"),
            ("tlog:", "names no file"),
            ("tlog:a.tlog?speed=0", "from 0.01"),
            ("tlog:a.tlog?speed=NaN", "from 0.01"),
            ("tlog:a.tlog?sped=2", "takes `?speed=2`"),
            ("udpin::14550?ids=0,1", "system id"),
            ("udpin::14550?speed=2", "takes `?ids=255,190` only"),
        ];
        for (given, expected) in cases {
            let message = given.parse::<LinkAddress>().expect_err(given).to_string();
            assert!(message.contains(expected), "{given}: {message}");
        }
    }
}
