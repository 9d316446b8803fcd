"""Links the archive of the board's processor. PlatformIO runs this for each program that uses the library."""

import os

# Boards name their processor in one of these ways.
FOLDERS = {
    "cortex-m0": "cortex-m0plus",
    "cortex-m0plus": "cortex-m0plus",
    "rp2040": "cortex-m0plus",
    "cortex-m4": "cortex-m4",
    "cortex-m4f": "cortex-m4",
    "cortex-m7": "cortex-m4",
    "cortex-m33": "cortex-m33",
    "rp2350": "cortex-m33",
    "esp32c2": "esp32c3",
    "esp32c3": "esp32c3",
    "esp32c6": "esp32c3",
    "esp32h2": "esp32c3",
}
# With arguments in registers of the FPU there is another archive.
HARD = {"cortex-m4": "fpv4-sp-d16-hard", "cortex-m33": "fpv5-sp-d16-hard"}


def folder_of(names, flags):
    """The folder below src of a board with these names, compiled with these flags; None if there is no archive for it."""
    folder = next((FOLDERS[name] for name in names if name in FOLDERS), None)
    if folder in HARD and "-mfloat-abi=hard" in flags:
        return os.path.join(folder, HARD[folder])
    return folder


def link(env):
    board = env.BoardConfig()
    names = [str(board.get(key, "")).lower() for key in ("build.cpu", "build.mcu")]
    flags = [str(flag) for key in ("CCFLAGS", "LINKFLAGS") for flag in env.get(key, [])]
    folder = folder_of(names, flags)
    if folder is None:
        raise SystemExit("ironout has no archive for the processor " + " or ".join(names))
    env.Append(LIBPATH=[os.path.join(os.getcwd(), "src", folder)], LIBS=["ironout"])


if "Import" in globals():
    Import("env")  # noqa: F821, given by PlatformIO
    link(env)  # noqa: F821
