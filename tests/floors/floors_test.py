"""The floors of the house: a room includes its own files and those of the rooms below it
(HACKING.md).
"""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Each room and its floor. Rooms of one floor do not include each other.
FLOORS = {
    "volumes": 0,
    "shaders": 0,
    "codecs": 1,
    "gpu": 2,
    "experiments/results": 3,
    "experiments/config": 4,
    "experiments/stages": 5,
    "experiments/analysis": 5,
    "experiments/run": 6,
    "experiments/tracking": 7,
    "experiments/cli": 8,
    "experiments/micro": 8,
}
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)
# Headers of libraries, and the rooms that alone may include them: codecs know no Vulkan, no YAML,
# no clock.
LIBRARIES = {
    "vulkan/": ("gpu/",),
    "yaml-cpp/": ("volumes/",),
    "nlohmann/": ("volumes/", "experiments/"),
    "chrono": ("volumes/", "gpu/", "experiments/"),
}


def room_of(path):
    """The room of a file named from the top of the tree; None for one that lies in none."""
    return next((room for room in FLOORS if path.startswith(room + "/")), None)


def sources():
    for top in ("volumes", "codecs", "gpu", "experiments", "shaders"):
        for path in sorted((ROOT / top).rglob("*")):
            if path.suffix in (".cpp", ".hpp", ".glsl", ".comp"):
                yield path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")


def codec_ids():
    """The ids of codecs/registry.cpp, as users write them and as files and functions are named."""
    registry = (ROOT / "codecs/registry.cpp").read_text(encoding="utf-8")
    names = set(re.findall(r"&(\w+)_codec\(\)", registry))
    return names | {name.replace("_", "-") for name in names}


class Floors(unittest.TestCase):
    def test_every_source_lies_in_a_room(self):
        for name, _ in sources():
            with self.subTest(name):
                self.assertIsNotNone(room_of(name))

    def test_no_room_includes_a_higher_one_or_one_of_its_own_floor(self):
        seen = 0
        for name, text in sources():
            for included in INCLUDE.findall(text):
                here, there = room_of(name), room_of(included)
                if there is None:  # beside the file, or a library
                    continue
                seen += 1
                with self.subTest(f"{name} includes {included}"):
                    self.assertTrue(here == there or FLOORS[here] > FLOORS[there])
        self.assertGreater(seen, 500)

    def test_libraries_stay_in_their_rooms(self):
        for name, text in sources():
            for header in re.findall(r"^#include <([^>]+)>", text, re.MULTILINE):
                for library, rooms in LIBRARIES.items():
                    if header.startswith(library):
                        with self.subTest(f"{name} includes {header}"):
                            self.assertTrue(name.startswith(rooms))

    def test_libraries_neither_print_nor_exit_nor_read_the_environment(self):
        forbidden = re.compile(r"\b(getenv|std::exit|std::abort|std::cout|std::cerr|printf)\s*[(<]")
        for name, text in sources():
            if name.startswith(("volumes/", "codecs/", "gpu/")):
                for number, line in enumerate(text.splitlines(), 1):
                    code = line.split("//")[0]
                    with self.subTest(f"{name}:{number}"):
                        self.assertIsNone(forbidden.search(code))

    def test_the_renderer_knows_no_codec_by_name(self):
        ids = codec_ids()
        self.assertTrue({"raw", "hdf5-gzip", "csgvr_c", "tvq"} <= ids)
        strings = 0
        for name, text in sources():
            if not name.startswith("gpu/"):
                continue
            for number, line in enumerate(text.splitlines(), 1):
                for quoted in re.findall(r'"([^"]*)"', line.split("//")[0]):
                    strings += 1
                    with self.subTest(f"{name}:{number}"):
                        self.assertFalse(ids & set(re.split(r"[^\w-]+", quoted)))
        self.assertGreater(strings, 300)


if __name__ == "__main__":
    unittest.main()
