//! What works on finished datasets: compare, export, report, files of the real camera.

mod compare;
mod compare_files;
mod compare_gap;
mod export_faults;
mod export_parts;
mod icon;
mod icon_faults;
mod report;
mod report_truth;
mod scans;
