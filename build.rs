//! Hands the target triple to the program: bytes are promised for one target, so datasets name it.

fn main() {
    println!("cargo:rustc-env=TARGET={}", std::env::var("TARGET").unwrap_or_default());
    println!("cargo:rerun-if-changed=build.rs");
}
