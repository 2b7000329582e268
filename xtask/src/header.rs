//! `cargo xtask header`: include/mepc.h from the source, by cbindgen under the rules of cbindgen.toml.

use std::path::Path;

use anyhow::{Context, Result, anyhow};

use crate::generated::settle;

pub fn run(root: &Path, check: bool) -> Result<()> {
    let rules = root.join("cbindgen.toml");
    let config = cbindgen::Config::from_file(&rules)
        .map_err(|error| anyhow!("{}: {error}", rules.display()))?;
    let mut text = Vec::new();
    cbindgen::Builder::new()
        .with_src(root.join("src/ffi/native.rs"))
        .with_src(root.join("src/ffi/iwan.rs"))
        .with_config(config)
        .generate()
        .context("cbindgen")?
        .write(&mut text);
    let text = String::from_utf8(text).context("cbindgen's output is not text")?;
    let text = text
        // The heading is for Rust's tools; what stands under it is for a C caller too.
        .replace("\n # Safety\n", "\n")
        // C89 knows no comments of this kind.
        .replace("// extern \"C\"", "/* extern \"C\" */")
        .replace("// __cplusplus", "/* __cplusplus */");
    settle(
        &root.join("include/mepc.h"),
        &text,
        check,
        "cargo xtask header",
    )?;
    println!(
        "include/mepc.h {}",
        if check { "up to date" } else { "written" }
    );
    Ok(())
}
