//! Profiles a second: the light of a band of rows, its exposure and its extraction, on the recipe of the full scan.

fn main() {
    divan::main();
}
