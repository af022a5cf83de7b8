"""Programs in Rust that need crates, which the tests build and run where cargo reaches them."""

import shutil
import subprocess

import pytest

# CODE ROWS WIDTH ACTIONS: runs a program for the kernel's virtual machine on rows of numbers, given by their bits
VIRTUAL_MACHINE = """\
use std::{env, fs};

fn main() {
    let given: Vec<String> = env::args().collect();
    let code = fs::read(&given[1]).expect("the code");
    let mut rows = fs::read(&given[2]).expect("the rows");
    let width: usize = given[3].parse().expect("the width");
    let machine = rbpf::EbpfVmRaw::new(Some(&code)).expect("a program that the verifier takes");
    let actions: Vec<u8> = rows
        .chunks_exact_mut(4 * width)
        .flat_map(|row| (machine.execute_program(row).expect("an answer") as i32).to_le_bytes())
        .collect();
    fs::write(&given[4], actions).expect("a place for the actions");
}
"""


def program(folder, source, *dependencies):
    """The path of a program that is built of `source`; skips where cargo or a crate is missing."""
    if shutil.which("cargo") is None:
        pytest.skip("cargo is not installed")
    (folder / "src").mkdir()
    (folder / "src" / "main.rs").write_text(source)
    head = (
        '[package]\nname = "program"\nversion = "0.0.0"\nedition = "2021"\n\n[profile.dev]\nopt-level = 1\ndebug = 0\n'
    )
    (folder / "Cargo.toml").write_text("\n".join([head, "[dependencies]", *dependencies, ""]))
    fetched = subprocess.run(["cargo", "fetch"], cwd=folder, capture_output=True, text=True, check=False)
    if fetched.returncode != 0:
        pytest.skip(f"cargo cannot get {dependencies}: {fetched.stderr.strip()[-200:]}")
    command = ["cargo", "build", "--offline", "--jobs", "1"]
    built = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    return folder / "target" / "debug" / "program"
