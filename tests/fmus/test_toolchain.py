import lief
import pytest

from adcs import AdcsError
from fmus.files import make_folder
from fmus.toolchain import (
    TARGETS,
    compile_step,
    header_step,
    host,
    included_files,
    is_up_to_date,
    link_step,
    run_steps,
    universal_binary,
    zig,
)


@pytest.fixture
def project(tmp_path):
    """A source that includes a header, in a folder whose name needs quoting."""
    folder = tmp_path / "with space"
    folder.mkdir()
    (folder / "size.hpp").write_text("constexpr int size = 3;\n")
    (folder / "main.cpp").write_text('#include "size.hpp"\n[[gnu::visibility("default")]] int f() { return size; }\n')
    return folder


def step(project, *flags):
    return compile_step(project / "main.cpp", project / "out" / "main.o", host(), *flags)


def test_compiles_once(project):
    run_steps([step(project)])
    made = (project / "out" / "main.o").stat().st_mtime_ns
    assert is_up_to_date(step(project))
    run_steps([step(project)])
    assert (project / "out" / "main.o").stat().st_mtime_ns == made


def test_knows_what_was_included(project):
    run_steps([step(project)])
    assert included_files(step(project)) == [project / "main.cpp", project / "size.hpp"]


def test_the_files_of_the_compiler_are_known_wherever_it_is_called(project, monkeypatch):
    (project / "size.hpp").write_text("#include <float.h>\nconstexpr int size = FLT_RADIX;\n")
    monkeypatch.chdir(zig().parent.parent)  # from where it names some of its files by relative paths
    run_steps([step(project)])
    assert included_files(step(project)) == [project / "main.cpp", project / "size.hpp"]


@pytest.mark.parametrize("name", ["main.cpp", "size.hpp"])
def test_an_edited_file_makes_it_out_of_date(project, name):
    run_steps([step(project)])
    (project / name).write_text((project / name).read_text() + "// edited\n")
    assert not is_up_to_date(step(project))


def test_touching_without_editing_does_not(project):
    run_steps([step(project)])
    (project / "size.hpp").touch()
    assert is_up_to_date(step(project))


def test_but_a_precompiled_header_is_made_anew(project):
    """The compiler refuses one of whose files the time is another, whatever is in them."""
    header = header_step(project / "size.hpp", project / "out" / "size.pch", host())
    for name in "fg":
        (project / "main.cpp").write_text(f"int {name}() {{ return size; }}\n")
        run_steps([header])
        run_steps([compile_step(project / "main.cpp", project / "out" / "main.o", host(), header=header)])
        assert is_up_to_date(header)
        (project / "size.hpp").touch()
        assert not is_up_to_date(header)


@pytest.mark.parametrize("content", ["", "[]", '{"format": "another"}', '{"command": "zig"}'])
def test_a_record_of_another_version_makes_it_out_of_date(project, content):
    run_steps([step(project)])
    step(project).record.write_text(content)
    assert not is_up_to_date(step(project))


def test_other_flags_and_other_compilers_make_it_out_of_date(project, monkeypatch):
    run_steps([step(project)])
    assert not is_up_to_date(step(project, "-DMORE"))
    monkeypatch.setattr("fmus.toolchain.metadata.version", lambda package: "0.0.1")
    assert not is_up_to_date(step(project))


def test_a_missing_header_or_output_makes_it_out_of_date(project):
    run_steps([step(project)])
    (project / "size.hpp").unlink()
    assert not is_up_to_date(step(project))
    (project / "size.hpp").write_text("constexpr int size = 3;\n")
    assert is_up_to_date(step(project))
    (project / "out" / "main.o").unlink()
    assert not is_up_to_date(step(project))


def test_a_compile_error_says_where_and_leaves_nothing_behind(project):
    (project / "main.cpp").write_text("int f() { return nothing; }\n")
    with pytest.raises(AdcsError, match=r"(?s)making main.o failed:.*main.cpp:1:18: error: .*nothing"):
        run_steps([step(project)])
    assert not (project / "out" / "main.o").exists()


def test_a_universal_binary_holds_its_slices(project):
    darwin = [target for target in TARGETS if target.name.endswith("darwin")]
    steps = [compile_step(project / "main.cpp", project / "out" / f"{t.name}.o", t) for t in darwin]
    run_steps(steps)
    slices = [s.output.read_bytes() for s in steps]

    fat = lief.MachO.parse(universal_binary(slices))

    assert [part.header.cpu_type.name for part in fat] == ["X86_64", "ARM64"]
    for part, content in zip(fat, slices, strict=True):
        assert part.fat_offset % (1 << 14) == 0
        assert universal_binary(slices)[part.fat_offset :].startswith(content)


def test_libraries_do_not_know_where_they_were_made(project):
    targets = [target for target in TARGETS if target.suffix != ".dll"]  # that one would take minutes the first time
    objects = {t: compile_step(project / "main.cpp", project / "out" / f"{t.name}.o", t) for t in targets}
    run_steps(objects.values())
    libraries = [link_step([o.output], project / "out" / t.name / f"main{t.suffix}", t) for t, o in objects.items()]
    run_steps(libraries)
    for library in libraries:
        assert str(project).encode() not in library.output.read_bytes(), library.output


def test_targets_have_distinct_places():
    assert len({t.name for t in TARGETS}) == len(TARGETS) == 5
    assert [t.name for t in TARGETS if t.fmi2_folder == "darwin64"] == ["x86_64-darwin", "aarch64-darwin"]
    assert len({t.fmi2_folder for t in TARGETS}) == 4
    assert host() in TARGETS


def test_an_unknown_machine_is_named(monkeypatch):
    monkeypatch.setattr("fmus.toolchain.platform.machine", lambda: "riscv64")
    with pytest.raises(AdcsError, match="this machine, riscv64-"):
        host()


def test_a_folder_that_cannot_be_made_is_one_line_with_the_way_out(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(
        AdcsError, match=r"file/cache: Not a directory: set XDG_CACHE_HOME to a folder for it$"
    ) as error:
        make_folder(tmp_path / "file" / "cache")
    assert error.value.failed
