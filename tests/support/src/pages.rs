//! A page of `gen report` as text.

use crate::program::Place;

/// Six boards in `planks`, in two splits, and their page.
pub fn planks_page(arguments: &str) -> (Place, String) {
    let place = Place::with(&[[
        "splits: {train: 0.8, validation: 0.1, test: 0.1}",
        "splits: {train: 0.5, validation: 0, test: 0.5}",
    ]]);
    place.make("planks", "--n 6 --samples-per-shard 4");
    let page = page(&place, "planks", arguments);
    (place, page)
}

/// The page of a dataset, in its usual place.
pub fn page(place: &Place, folder: &str, arguments: &str) -> String {
    place.done(&format!("report {folder} --no-timing {arguments}"));
    std::fs::read_to_string(place.path(&format!("{folder}/reports/report.html"))).expect("the page is there")
}

/// The same of a damaged dataset: its page is written, and the exit status is 1.
pub fn page_of_damage(place: &Place, folder: &str, arguments: &str) -> String {
    place.run(&format!("report {folder} --no-timing {arguments}")).refused(&[folder, "damaged", "the page", "lists"]);
    std::fs::read_to_string(place.path(&format!("{folder}/reports/report.html"))).expect("the page is there")
}

/// Values of an attribute in the order of the page.
pub fn values<'a>(page: &'a str, attribute: &str) -> Vec<&'a str> {
    let start = format!(" {attribute}=\"");
    page.split(&start).skip(1).filter_map(|rest| rest.split('"').next()).collect()
}

/// The elements of a kind: what lies between `<article class="card"` and its end, for instance.
pub fn between<'a>(page: &'a str, start: &str, end: &str) -> Vec<&'a str> {
    page.split(start).skip(1).filter_map(|rest| rest.split(end).next()).collect()
}
