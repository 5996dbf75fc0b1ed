//! Files of the real camera (iCon .dat and .xml): a scan, or one sensor frame.

use std::path::Path;

use super::map_numbers::MAX_PIXELS;
use super::scan_format::{ScanContent, ScanFormat};
use super::{RangeUnit, ScanMaps, SensorFrame};
use crate::icon::{self, Content, PlaneContent, PlaneNumbers, Traits};
use dataset::Fault;

/// Two files, `NAME.xml` and `NAME.dat`.
pub(super) const FORMAT: ScanFormat = ScanFormat {
    endings: &[("xml", ".xml with .dat", true), ("dat", "", false)],
    stated: None,
    read: |path, _| maps(path).map(|maps| ScanContent::Scan(Box::new(maps))),
};

fn maps(path: &Path) -> Result<ScanMaps, Fault> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    match icon::open(path)? {
        Content::Image(image) => {
            let exposures = vec![SensorFrame { cols: image.cols, profile: None, dn: image.dn }];
            Ok(ScanMaps { name, exposures, ..ScanMaps::default() })
        }
        Content::Scan(mut reader) => {
            let (unit, world) = match reader.traits() {
                Traits::World(world) => (RangeUnit::Mm, Some(world)),
                Traits::Sensor(sensor) => (RangeUnit::Px { sensor_rows: sensor.region_rows }, None),
            };
            let rows = reader.rows();
            let pixels = reader.width().saturating_mul(rows);
            if pixels > MAX_PIXELS {
                let what = format!("its {rows} profiles of {} columns are {pixels} pixels", reader.width());
                let remedy = format!("at most {MAX_PIXELS} are compared: give a part of the scan");
                return Err(Fault::at(path, what, remedy));
            }
            let scan = reader.read(0, rows)?;
            let mut unused = reader.unused().to_vec();
            unused.extend(scan.plane(PlaneContent::Mark).map(|_| "Mark INT".to_owned()));
            let x = scan.places();
            Ok(ScanMaps {
                name,
                cols: scan.width,
                rows,
                unit,
                first_mm: world.filter(|_| x.is_none()).map(|world| world.lower[0] + 0.5 * world.col_mm(scan.width)),
                col_mm: scan.col_mm(),
                x,
                unused,
                row_mm: world.and_then(|world| world.row_mm),
                range: scan.heights(),
                reflectance: scan.light_dn().map(|dn| dn.iter().map(|&dn| f32::from(dn)).collect()),
                scatter: match scan.plane(PlaneContent::Scatter) {
                    Some(PlaneNumbers::Byte(dn)) => Some(dn.iter().map(|&dn| f32::from(dn)).collect()),
                    Some(PlaneNumbers::Word(dn)) => Some(dn.iter().map(|&dn| f32::from(dn)).collect()),
                    _ => None,
                },
                ..ScanMaps::default()
            })
        }
    }
}
