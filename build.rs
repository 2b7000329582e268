//! The name of the shared library that a linked program records and asks for at run time. It stands for the interface:
//! version 0.1.x is libmepc.so.0.1, whatever the file is called. `make library` and `make install` make the links.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let variable = |name: &str| std::env::var(name).unwrap_or_default();
    let version = |part: &str| variable(&format!("CARGO_PKG_VERSION_{part}"));
    let interface = format!("{}.{}", version("MAJOR"), version("MINOR"));
    if variable("CARGO_CFG_TARGET_VENDOR") == "apple" {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-install_name,@rpath/libmepc.{interface}.dylib");
    } else if variable("CARGO_CFG_TARGET_FAMILY") == "unix" {
        println!("cargo::rustc-cdylib-link-arg=-Wl,-soname,libmepc.so.{interface}");
    }
}
