//! What works on finished datasets: compare, export, report.

mod compare;
mod compare_files;
mod compare_gap;
mod export_faults;
mod export_parts;
mod report;
mod report_truth;
