//! Scans in files. Those of bare numbers hold a map each (grey images, grids as text), or a cloud of points; what their
//! numbers are the user states ([`StatedScale`]).

use std::path::{Path, PathBuf};

use super::formats::{format_of, map_format, stated_form};
use super::gocator_frame::GocatorSurface;
use super::map_numbers::{MapNumbers, ScanPoints};
use super::scan_format::{CsvForm, ScanContent, StatedForm};
use super::stated_scale::{self, StatedScale};
use super::{RangeUnit, ScanMaps, point_grid};
use dataset::Fault;

/// The files of one scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct MapFiles {
    /// Range, or a cloud of points.
    pub(super) range: PathBuf,
    /// Reflectance on the same grid.
    pub(super) reflectance: Option<PathBuf>,
    /// Scatter on the same grid.
    pub(super) scatter: Option<PathBuf>,
}

impl MapFiles {
    /// A file beside which there is no other.
    pub(super) fn alone(range: PathBuf) -> Self {
        Self { range, reflectance: None, scatter: None }
    }
}

/// Reads a scan.
pub(super) fn read(files: &MapFiles, stated: &StatedScale) -> Result<ScanMaps, Fault> {
    let path = &files.range;
    let format = format_of(path).unwrap_or_else(|| map_format(path));
    let mut maps = match (format.read)(path, stated.csv)? {
        ScanContent::Scan(maps) => return Ok(*maps),
        ScanContent::Grid(map) => of_map(files, stated, &map, None)?,
        ScanContent::Surface(surface) => of_surface(files, stated, &surface)?,
        ScanContent::Points(points) => of_points(files, stated, &points)?,
    };
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    maps.name = stem.strip_suffix(".range").unwrap_or(&stem).into();
    Ok(maps)
}

/// A surface that says itself how it is scaled.
fn of_surface(files: &MapFiles, stated: &StatedScale, surface: &GocatorSurface) -> Result<ScanMaps, Fault> {
    let path = &files.range;
    let options = [(stated.col_mm, surface.pitch_mm[0], "--col-mm"), (stated.row_mm, surface.pitch_mm[1], "--row-mm")];
    if let Some((.., option)) = options.iter().find(|(stated, told, _)| stated.is_some() && told.is_some()) {
        return Err(Fault::at(path, "it says itself where its points are", format!("leave {option} away")));
    }
    let mut maps = of_map(files, stated, &surface.range, Some(1.0))?;
    maps.col_mm = maps.col_mm.or(surface.pitch_mm[0]);
    maps.row_mm = maps.row_mm.or(surface.pitch_mm[1]);
    maps.first_mm = Some(surface.first_mm);
    if let Some(intensity) = &surface.intensity {
        if let Some(other) = &files.reflectance {
            let what = format!("it goes with {}, which holds its own intensity", path.display());
            return Err(Fault::at(other, what, "leave it away"));
        }
        let light = stated_scale::reflectance(intensity, stated.bits(path, Some(8))?);
        maps.reflectance =
            Some(light.map_err(|what| Fault::at(path, what, "export it again with intensity of 8 bits"))?);
    }
    Ok(maps)
}

/// A map; `unit_mm` is what the file says of one of its numbers [mm].
fn of_map<'f>(
    files: &'f MapFiles,
    stated: &StatedScale,
    map: &MapNumbers,
    unit_mm: Option<f64>,
) -> Result<ScanMaps, Fault> {
    let path = &files.range;
    if stated.cols.is_some() && stated_form(path) == Some(StatedForm::Csv) {
        return Err(Fault::at(path, "it is a map, which says its columns itself", "leave --cols away"));
    }
    let (unit, scale) = stated.height_scale(path, unit_mm)?;
    let range = stated.heights(path, &map.numbers, scale, map.bits.is_some())?;
    let beside = |other: &'f Option<PathBuf>| -> Result<Option<(&'f Path, MapNumbers)>, Fault> {
        let Some(other) = other else { return Ok(None) };
        let ScanContent::Grid(found) = (map_format(other).read)(other, Some(CsvForm::Grid))? else {
            return Err(Fault::at(other, "it is no map alone", "give a map on the grid of Range"));
        };
        if (found.cols, found.rows) != (map.cols, map.rows) {
            let what = format!("it is {} x {}, and Range {} x {}", found.cols, found.rows, map.cols, map.rows);
            return Err(Fault::at(other, what, "give maps on one grid"));
        }
        Ok(Some((other, found)))
    };
    let maps = [beside(&files.reflectance)?, beside(&files.scatter)?];
    // A number of 16 bits may hold fewer; one of 8 holds 8.
    let eight = maps.iter().flatten().next().and_then(|(_, map)| map.bits.filter(|bits| *bits == 8));
    let maps = maps.map(|map| map.map(|(path, map)| (path, map.numbers)));
    let [reflectance, scatter] = light(stated, eight.map(u64::from), maps)?;
    Ok(ScanMaps {
        cols: map.cols,
        rows: map.rows,
        unit,
        col_mm: stated.col_mm,
        row_mm: stated.row_mm,
        range,
        reflectance,
        scatter,
        ..ScanMaps::default()
    })
}

/// Reflectance and Scatter on the scale of 8 bits.
type LightMaps = [Option<Vec<f32>>; 2];

/// Maps of light with their files; `of_file` is what the type of the first of them says of the bits.
fn light(
    stated: &StatedScale,
    of_file: Option<u64>,
    [reflectance, scatter]: [Option<(&Path, Vec<f64>)>; 2],
) -> Result<LightMaps, Fault> {
    let Some((path, _)) = reflectance.as_ref().or(scatter.as_ref()) else { return Ok([None, None]) };
    let bits = stated.bits(path, of_file)?;
    let remedy = "give the camera's bits with --bits";
    let reflectance = reflectance
        .map(|(path, map)| stated_scale::reflectance(&map, bits).map_err(|what| Fault::at(path, what, remedy)));
    Ok([reflectance.transpose()?, scatter.map(|(_, map)| stated_scale::scatter(&map, bits))])
}

fn of_points(files: &MapFiles, stated: &StatedScale, points: &ScanPoints) -> Result<ScanMaps, Fault> {
    let path = &files.range;
    if let Some(other) = files.reflectance.as_ref().or(files.scatter.as_ref()) {
        let what = format!("it goes with {}, whose points hold their own Reflectance and Scatter", path.display());
        return Err(Fault::at(other, what, "leave it away, or give Range as a map"));
    }
    let (unit, scale) = stated.height_scale(path, points.unit_mm)?;
    if unit != RangeUnit::Mm {
        let remedy = "give --mm-per-count or --um-per-count: one unit for x, y and z";
        return Err(Fault::at(path, "points have heights, not sensor rows", remedy));
    }
    let placed = |&[x, y, z]: &[f64; 3]| stated.height(z, scale).map(|z| [scale * x, scale * y, z]);
    let places: Result<Vec<[f64; 3]>, String> = points.places.iter().map(placed).collect();
    let places = places.map_err(|what| StatedScale::unbelievable(path, what))?;
    if let (Some([cols, rows]), Some(other)) = (points.organised, stated.cols)
        && cols != other
    {
        let what = format!("its header tells {rows} profiles of {cols} columns");
        return Err(Fault::at(path, what, "leave --cols away"));
    }
    let pitches = [stated.col_mm, stated.row_mm];
    let grid = match points.organised.map(|[cols, _]| cols).or(stated.cols) {
        Some(cols) => point_grid::stored_in_order(&places, cols, pitches),
        None => point_grid::on_grid(&places, pitches),
    };
    let grid = grid.map_err(|what| {
        let remedy =
            "give --cols where points are stored profile by profile, missing ones too, else --col-mm and --row-mm";
        Fault::at(path, what, remedy)
    })?;
    let on_grid = |map: &[f64]| -> Vec<f64> {
        grid.points.iter().map(|point| point.map_or(f64::NAN, |i| map[i as usize])).collect()
    };
    let maps = [&points.reflectance, &points.scatter].map(|map| map.as_ref().map(|map| (path.as_path(), on_grid(map))));
    let [reflectance, scatter] = light(stated, points.bits, maps)?;
    Ok(ScanMaps {
        cols: grid.cols,
        rows: grid.rows,
        unit,
        first_mm: grid.first_mm,
        col_mm: grid.pitch_mm[0],
        row_mm: grid.pitch_mm[1],
        range: grid.points.iter().map(|point| point.map_or(f64::NAN, |i| places[i as usize][2])).collect(),
        reflectance,
        scatter,
        ..ScanMaps::default()
    })
}
