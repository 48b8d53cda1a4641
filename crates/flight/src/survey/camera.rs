//! The camera of a survey: what its picture shows from a height, and which height shows what.
//!
//! All of it is the pinhole camera looking straight down: a picture's scale is `f / H` (P. R. Wolf, B. A. Dewitt, B. E.
//! Wilkinson, "Elements of Photogrammetry", 4th ed., eq. 6-1), so that a pixel of pitch `p` covers `p H / f` of level
//! ground.

/// Sensor and lens of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "describe", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
#[cfg_attr(feature = "describe", serde(deny_unknown_fields))]
pub struct Camera {
    /// Width of the sensor, mm, 0.5 to 200: the side that has `image_width_px`.
    pub sensor_width_mm: f64,
    /// Height of the sensor, mm, 0.5 to 200.
    pub sensor_height_mm: f64,
    /// Pixels across the width, 16 to 100,000.
    pub image_width_px: u32,
    /// Pixels across the height, 16 to 100,000.
    pub image_height_px: u32,
    /// Real focal length, not its equivalent on film, mm, 0.5 to 2,000.
    pub focal_length_mm: f64,
    /// Least time between two pictures, s, 0 to 60; 0: not known.
    #[cfg_attr(feature = "describe", serde(default), schema(required = true))]
    pub min_interval_s: f64,
}

/// The ground that a picture shows, m, when the camera looks straight down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    /// Across the track.
    pub across_m: f64,
    /// Along the track.
    pub along_m: f64,
}

impl Camera {
    /// Ground that a pixel covers from a height above it, m: `p H / f`, the coarser of the two directions where pixels
    /// are not square.
    pub fn gsd_m(&self, height_m: f64) -> f64 {
        height_m * self.pitch_mm() / self.focal_length_mm
    }

    /// Height above the ground from which a pixel covers that much of it, m: `g f / p`.
    pub fn height_m(&self, gsd_m: f64) -> f64 {
        gsd_m * self.focal_length_mm / self.pitch_mm()
    }

    /// Footprint of a picture from a height above the ground: `s H / f` in each direction.
    pub fn footprint(&self, height_m: f64, is_landscape: bool) -> Footprint {
        let side = |sensor_mm: f64| sensor_mm * height_m / self.focal_length_mm;
        let (width_m, height_m) = (side(self.sensor_width_mm), side(self.sensor_height_mm));
        if is_landscape {
            Footprint { across_m: width_m, along_m: height_m }
        } else {
            Footprint { across_m: height_m, along_m: width_m }
        }
    }

    /// Distance between two pixels on the sensor, mm.
    fn pitch_mm(&self) -> f64 {
        let across = self.sensor_width_mm / f64::from(self.image_width_px);
        across.max(self.sensor_height_mm / f64::from(self.image_height_px))
    }
}

/// A camera by name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownCamera {
    /// Its name; for those that QGroundControl knows, the one by which it knows them.
    pub name: &'static str,
    /// The camera.
    pub camera: Camera,
}

impl KnownCamera {
    /// Whether QGroundControl has it by this name.
    pub fn is_known_to_qgroundcontrol(&self) -> bool {
        !self.name.starts_with("Raspberry")
    }
}

const fn known(
    name: &'static str,
    [sensor_width_mm, sensor_height_mm]: [f64; 2],
    [image_width_px, image_height_px]: [u32; 2],
    focal_length_mm: f64,
    min_interval_s: f64,
) -> KnownCamera {
    let camera =
        Camera { sensor_width_mm, sensor_height_mm, image_width_px, image_height_px, focal_length_mm, min_interval_s };
    KnownCamera { name, camera }
}

/// Cameras that are flown on small planes.
///
/// Data of the manufacturers, as QGroundControl keeps them (`src/Camera/CameraMetaData.json`); those of Raspberry Pi
/// from its documentation ("Camera", "Hardware specification"), the HQ camera with the 6 mm lens that is sold for it.
pub const CAMERAS: [KnownCamera; 15] = [
    known("Canon S100 PowerShot", [7.6, 5.7], [4000, 3000], 5.2, 0.0),
    known("Canon SX260 HS PowerShot", [6.17, 4.55], [4000, 3000], 4.5, 0.0),
    known("Flir Duo Pro R", [10.88, 8.704], [640, 512], 19.0, 1.0),
    known("GoPro Hero 4", [6.17, 4.55], [4000, 3000], 2.98, 0.0),
    known("Parrot Sequioa RGB", [6.17, 4.63], [4608, 3456], 4.9, 1.0),
    known("Raspberry Pi Camera Module 3", [6.451, 3.629], [4608, 2592], 4.74, 0.0),
    known("Raspberry Pi HQ Camera 6mm", [6.287, 4.712], [4056, 3040], 6.0, 0.0),
    known("RedEdge", [4.8, 3.6], [1280, 960], 5.5, 0.0),
    known("Ricoh GR II", [23.7, 15.7], [4928, 3264], 18.3, 0.0),
    known("Sentera 65R Sensor", [29.9, 22.4], [9344, 7000], 27.4, 0.3),
    known("Sony DSC-RX0", [13.2, 8.8], [4800, 3200], 7.7, 0.0),
    known("Sony RX100 II 28mm", [13.2, 8.8], [5472, 3648], 10.4, 0.0),
    known("Sony a6000 16mm", [23.5, 15.6], [6000, 4000], 16.0, 1.0),
    known("Sony a6000 35mm", [23.5, 15.6], [6000, 4000], 35.0, 1.0),
    known("Sony a7R II Sony 28mm f/2.0", [35.814, 23.876], [7952, 5304], 28.0, 1.0),
];

/// A camera of [`CAMERAS`] by its name, whatever its capitals.
pub fn camera_named(name: &str) -> Option<KnownCamera> {
    CAMERAS.into_iter().find(|known| known.name.eq_ignore_ascii_case(name.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_goes_both_ways() {
        for known in CAMERAS {
            let camera = known.camera;
            for height_m in [30.0, 120.0, 400.0] {
                assert!((camera.height_m(camera.gsd_m(height_m)) - height_m).abs() < 1e-9, "{}", known.name);
                let [wide, tall] = [camera.footprint(height_m, true), camera.footprint(height_m, false)];
                assert_eq!((wide.across_m, wide.along_m), (tall.along_m, tall.across_m));
                // As many pixels as the picture has, each as large as said or a little less.
                let pixels_m = camera.gsd_m(height_m) * f64::from(camera.image_width_px);
                assert!((0.999 * wide.across_m..1.04 * wide.across_m).contains(&pixels_m), "{}", known.name);
            }
        }
        // An a6000 with 16 mm, 100 m up: 23.5 mm over 16 mm of 100 m.
        let sony = camera_named("sony A6000 16MM").unwrap().camera;
        assert_eq!(sony.footprint(100.0, true), Footprint { across_m: 146.875, along_m: 97.5 });
        assert!((sony.gsd_m(100.0) - 0.024_48).abs() < 1e-5);
        assert_eq!(camera_named("a camera that nobody has"), None);
    }
}
