"""Machines of 32 bits: builds a C program for one and runs it there, an emulated Cortex-M4 or x86 with its x87."""

import shutil
import subprocess

import pytest

# The emulator's MPS2 board starts from the table at 0; its memory ends at 4 MiB. The FPU is off until CPACR allows it.
VECTORS = """\
extern void _start(void);
static void reset(void)
{
    *(volatile unsigned int *)0xE000ED88u |= 0xFu << 20;
    __asm__ volatile("dsb\\n\\tisb");
    _start();
}
struct table { unsigned int stack; void (*reset)(void); };
const struct table vectors __attribute__((section(".vectors"), used)) = {0x400000u, reset};
"""
ARM = "arm-none-eabi-gcc -mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16"
EMULATOR = "qemu-system-arm -M mps2-an386 -nographic -monitor none -serial none -kernel program".split()  # noqa: SIM905
X87 = "gcc -m32 -mfpmath=387"
MACHINES = ("cortex-m4", "x87")


def build(machine, folder, source, flags):
    """Builds `source`, in `folder` or given by its whole path, as `program`; skips where a tool is missing."""
    if machine == "cortex-m4":
        for tool in ("arm-none-eabi-gcc", "qemu-system-arm"):
            if shutil.which(tool) is None:
                pytest.skip(f"{tool} is not installed")
        (folder / "vectors.c").write_text(VECTORS)
        compiler = [*ARM.split(), "--specs=rdimon.specs", "-Wl,--section-start=.vectors=0"]
        works = "int main(void) { return 0; }\n", "newlib with its semihosting is not installed"
        source = [source, "vectors.c"]
    else:
        if shutil.which("gcc") is None:
            pytest.skip("gcc is not installed")
        compiler = X87.split()
        # what makes x87 worth a test: it keeps more digits than double has
        test = "#include <float.h>\nint main(void) { return FLT_EVAL_METHOD != 2 || sizeof(long) != 4; }\n"
        works = test, "gcc -m32 -mfpmath=387 does not build here (gcc-multilib)"
        source = [source]
    (folder / "works.c").write_text(works[0])
    if _compiled(compiler, folder, ["works.c", *source[1:]], "works", ["-std=c99"]).returncode != 0:
        pytest.skip(works[1])
    if machine == "x87":
        subprocess.run([str(folder / "works")], check=True)
    built = _compiled(compiler, folder, source, "program", flags)
    assert built.returncode == 0, built.stderr


def _compiled(compiler, folder, sources, program, flags):
    command = [*compiler, *flags, *map(str, sources), "-o", program]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def run(machine, folder, *arguments):
    """Runs `program` in `folder`; files are opened from there on either machine."""
    command = [str(folder / "program"), *arguments]
    if machine == "cortex-m4":
        given = ",".join(f"arg={argument}" for argument in ("program", *arguments))
        command = [*EMULATOR, "-semihosting-config", f"enable=on,target=native,{given}"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=120)
