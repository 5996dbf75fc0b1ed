//! Sample of a dataset: its row, and its images as numbers of the PNG columns, whichever file they are stored in.

use output_schema::row::LIGHT;
use output_schema::{DatasetHead, ManifestSample};
use serde_json::{Map, Value};

use dataset::{
    Dataset, ExrMaps, Fault, Grey, JsonRow, Table, range_numbers, read_png_of, rounded8, rounded16, write_png,
};
use optical_bench::split::Split;

/// A part of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Region {
    /// First row [px].
    pub top: usize,
    /// First column [px].
    pub left: usize,
    /// Rows [px].
    pub rows: usize,
    /// Columns [px].
    pub cols: usize,
}

/// One sample.
#[derive(Debug)]
pub struct ExportSample<'a> {
    /// Number in the dataset.
    pub index: u64,
    /// Name of its files.
    pub key: String,
    /// Part of the dataset.
    pub split: Split,
    /// Name of the recipe's class.
    pub class: String,
    /// Columns of its images [px].
    pub cols: usize,
    /// Rows of its images [px].
    pub rows: usize,
    /// Everything that the table says of it.
    pub row: JsonRow,
    head: &'a DatasetHead,
    table: &'a Table,
    exr: Option<ExrMaps>,
}

impl<'a> ExportSample<'a> {
    /// The sample of a row, which must be the one that the manifest lists; with the maps of its EXR file where asked.
    pub(super) fn new(
        dataset: &'a Dataset,
        table: &'a Table,
        row: JsonRow,
        listed: &ManifestSample,
        with_exr: bool,
    ) -> Result<Self, Fault> {
        let head = dataset.head();
        let told = |what: String| table.damaged(what).of_part(format!("sample {}", listed.index));
        let facts = || {
            let is_listed = row.whole("index")? == listed.index
                && row.text("id")? == listed.id
                && row.text("split")? == listed.split;
            if !is_listed {
                return Err("its row is that of another sample".to_owned());
            }
            let size = [row.whole("cols")?, row.whole("rows")?];
            if size != [head.images.cols, head.images.rows] {
                return Err(format!("it has {} x {} pixels, not those of dataset.json", size[0], size[1]));
            }
            let class = row.whole("class")? as usize;
            let class = head.classes.get(class).ok_or_else(|| format!("there is no class {class}"))?;
            Ok((class.clone(), size))
        };
        let (class, [cols, rows]) = facts().map_err(told)?;
        let split = Split::ALL.into_iter().find(|split| split.name() == listed.split);
        let split = split.ok_or_else(|| told(format!("there is no split `{}`", listed.split)))?;
        let exr = if with_exr { Some(dataset.exr(table.shard, &listed.id)?) } else { None };
        let (cols, rows) = (cols as usize, rows as usize);
        Ok(Self { index: listed.index, key: key(listed.index), split, class, cols, rows, row, head, table, exr })
    }

    /// `dataset.json`.
    pub(super) fn head(&self) -> &DatasetHead {
        self.head
    }

    /// An error that names this sample.
    pub(super) fn fault(&self, what: impl AsRef<str>) -> Fault {
        Fault::damaged(&self.table.path, what.as_ref()).of_part(format!("sample {}", self.index))
    }

    /// What a number of Range means: `offset + number * scale` [mm or px].
    pub(super) fn range_scale(&self) -> Result<[f64; 2], Fault> {
        let unit = self.head.range_unit();
        let number = |what: &str| self.row.number(&format!("range_{what}_{unit}")).map_err(|e| self.fault(e));
        Ok([number("offset")?, number("scale")?])
    }

    /// An image in the numbers of its PNG column `[rows, cols]`; from the EXR file where there is no such column.
    ///
    /// # Errors
    /// Where it is missing or damaged.
    pub fn grey(&self, name: &str) -> Result<Grey, Fault> {
        let told = |what: String| self.fault(format!("`{name}`: {what}"));
        let is_eight = name == "label" || LIGHT.contains(&name) && self.head.images.bits <= 8;
        let grey = match self.row.image(name) {
            Some(png) => read_png_of(png, (self.cols as u64, self.rows as u64)).map_err(told)?,
            None => {
                let channel = self.exr.as_ref().and_then(|exr| exr.channel(name));
                let numbers = channel.ok_or_else(|| told("there is no such EXR channel".into()))?.numbers.clone();
                if numbers.len() != self.cols * self.rows {
                    return Err(told(format!("its EXR file has not {} x {} pixels", self.cols, self.rows)));
                }
                match name {
                    "range" => {
                        let [offset, scale] = self.range_scale()?;
                        Grey::Sixteen(range_numbers(&numbers, offset, scale))
                    }
                    _ if is_eight => Grey::Eight(rounded8(&numbers)),
                    _ => Grey::Sixteen(rounded16(&numbers)),
                }
            }
        };
        if is_eight != (grey.bits() == 8) {
            return Err(told(format!("it has {} bits a pixel", grey.bits())));
        }
        Ok(grey)
    }

    /// An image as PNG: the bytes that are stored, after they were decoded once, else written from the EXR file.
    ///
    /// # Errors
    /// Where it is missing or damaged.
    pub fn png(&self, name: &str) -> Result<Vec<u8>, Fault> {
        let grey = self.grey(name)?;
        Ok(self.row.image(name).map_or_else(|| write_png(&grey, self.cols), <[u8]>::to_vec))
    }

    /// Every value of the row but images, with names beside the numbers of classes.
    pub fn json(&self) -> Value {
        let mut values = self.row.values.clone();
        values.insert("class_name".into(), self.class.clone().into());
        if let Some(Value::Array(objects)) = values.get_mut("objects") {
            for object in objects.iter_mut().filter_map(Value::as_object_mut) {
                for of in ["class", "state"] {
                    let name = object.get(of).and_then(Value::as_u64).map(|value| self.pixel_class(value));
                    object.insert(format!("{of}_name"), name.map_or(Value::Null, Value::from));
                }
            }
        }
        Value::Object(values)
    }

    /// Name of a pixel class; empty where there is none.
    pub(super) fn pixel_class(&self, value: u64) -> &str {
        usize::try_from(value).ok().and_then(|value| self.head.pixel_classes.get(value)).map_or("", String::as_str)
    }

    /// The objects of the row.
    pub(super) fn objects(&self) -> Result<Vec<&Map<String, Value>>, Fault> {
        let objects = self.row.values.get("objects").and_then(Value::as_array);
        let objects = objects.ok_or_else(|| self.fault("`objects` is no list"))?;
        let object = |value| Value::as_object(value).ok_or_else(|| self.fault("`objects` holds no structs"));
        objects.iter().map(object).collect()
    }
}

/// The name of a sample's files: its index, with as many digits for all, so that names sort as numbers do.
pub(super) fn key(index: u64) -> String {
    format!("{index:08}")
}
