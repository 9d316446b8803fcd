"""Every call, with arrays, tables, errors, signals and plots."""

import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import ironout
from ironout import IronoutError


def test_arrays_give_the_log(clean):
    gyro = np.column_stack([clean[name] for name in ("gx_radps", "gy_radps", "gz_radps")])
    accel = np.column_stack([clean[name] for name in ("ax_mps2", "ay_mps2", "az_mps2")])
    columns = {name: clean[name] for name in ("heading_deg", "temp_c", "current_a", "height_m")}
    fit = ironout.fit(clean.mag, t=clean.t, accel=accel, gyro=gyro, **columns)
    assert fit.offset_ut == ironout.fit(clean).offset_ut
    assert fit.accepted and fit.calibration.effects == []
    truth = np.array(clean.truth["offset_ut"])
    std = np.array(fit.std_errors["offset_ut"])
    assert (np.abs(fit.calibration.offset_ut - truth) < 4 * std).all()


def test_arrays_are_neither_kept_nor_changed(clean):
    mag = clean.mag
    before = mag.copy()
    fitted = ironout.fit(mag)
    mag[:] = 0
    assert fitted.offset_ut == ironout.fit(before).offset_ut


@pytest.mark.parametrize("library", ["dict", "pandas", "polars", "pyarrow", "parquet", "feather", "xarray"])
def test_tables(library, clean, tmp_path):
    columns = clean.to_dict()
    if library == "dict":
        table = columns
    elif library == "pandas":
        table = pytest.importorskip("pandas").DataFrame(columns)
    elif library == "polars":
        table = pytest.importorskip("polars").DataFrame(columns)
    elif library == "pyarrow":
        table = pytest.importorskip("pyarrow").table(columns)
    elif library == "feather":
        table = tmp_path / "log.feather"
        pytest.importorskip("pyarrow.feather").write_feather(pytest.importorskip("pyarrow").table(columns), table)
    elif library == "parquet":
        pyarrow = pytest.importorskip("pyarrow")
        pytest.importorskip("pyarrow.parquet").write_table(pyarrow.table(columns), tmp_path / "log.parquet")
        table = tmp_path / "log.parquet"
    else:
        table = pytest.importorskip("xarray").Dataset({name: ("row", values) for name, values in columns.items()})
    log = ironout.read(table)
    assert log.columns == clean.columns and len(log) == len(clean)
    assert all(np.array_equal(log[name], clean[name], equal_nan=True) for name in log.columns)


def test_foreign_names_dates_text_and_gaps(clean):
    pandas = pytest.importorskip("pandas")
    milligauss = {f"Mag{axis} (mG)": clean[f"m{axis.lower()}_ut"] * 10 for axis in "XYZ"}
    frame = pandas.DataFrame({**milligauss, "note": "text", "temp_c": clean["temp_c"]})
    frame.loc[3, "temp_c"] = None
    with pytest.warns(ironout.IronoutWarning, match="note does not contain numbers"):
        log = ironout.read(frame)
    assert np.allclose(log.mag, clean.mag, rtol=1e-12) and np.isnan(log["temp_c"][3])
    log = ironout.read(dict(zip("abc", clean.mag.T)), map={"mx_ut": "a", "my_ut": "b", "mz_ut": "c"}, derive={"d": "mx_ut*2"})
    assert np.array_equal(log["d"], 2 * clean["mx_ut"])
    dated = pandas.DataFrame(
        {name: clean[name] for name in ("mx_ut", "my_ut", "mz_ut")},
        index=pandas.to_datetime(1_780_000_000 + clean.t, unit="s"),
    )
    assert np.allclose(np.diff(ironout.read(dated).t), np.diff(clean.t), atol=1e-5)


def test_errors_have_the_place_and_the_remedy(tmp_path, clean, hidden):
    with pytest.raises(IronoutError, match="no such file") as caught:
        ironout.read(tmp_path / "nothing.csv")
    assert caught.value.file.endswith("nothing.csv") and caught.value.exit_status == 2
    bad = tmp_path / "bad.csv"
    bad.write_text("t_s,mx_ut,my_ut,mz_ut\n0,1,2,3\n1,1,,3\n")
    with pytest.raises(IronoutError) as caught:
        ironout.fit(bad)
    assert (caught.value.line, caught.value.column) == (3, "my_ut")
    assert str(caught.value).startswith(f"{bad}:3: column my_ut: the cell is empty")
    mag = clean.mag.copy()
    mag[1, 1] = np.nan
    with pytest.raises(IronoutError) as caught:
        ironout.fit(mag)
    assert (caught.value.line, caught.value.column) == (3, "my_ut")
    with pytest.raises(IronoutError, match="--add offset:no_column"):
        ironout.fit(clean, add="offset:no_column")
    refused = ironout.fit(hidden)
    assert not refused.accepted and refused.reasons
    with pytest.raises(IronoutError, match="the fit was refused: The predicted error"):
        refused.calibration
    with pytest.raises(IronoutError, match="not a valid ironout calibration"):
        ironout.Calibration("{}")
    with pytest.raises(IronoutError, match="expected one of rust, c"):
        ironout.fit(clean).calibration.export("fortran")
    with pytest.raises(ValueError, match="n rows with x, y and z"):
        ironout.fit(clean["mx_ut"])
    with pytest.raises(TypeError, match="is not a log"):
        ironout.read(3)
    with pytest.raises(KeyError, match="the log has t_s"):
        clean["nothing"]


def test_diagnosis_names_the_current(hidden):
    diagnosis = ironout.diagnose(hidden)
    assert diagnosis.verdict == "missing" and diagnosis.missing == ["offset:current_a"]
    assert diagnosis.steps[1].added == "offset:current_a"
    assert diagnosis.steps[1].holdout_rms_ut < 0.5 * diagnosis.steps[0].holdout_rms_ut
    assert "current" in diagnosis.sentence and "current_a" in diagnosis._repr_html_()
    assert set(diagnosis.to_frame().columns) >= {"id", "status", "p_value"}
    assert len(diagnosis.steps_frame()) == 2


def test_calibration_with_effects_is_kept_and_applied(hidden, tmp_path):
    calibration = ironout.fit(hidden, add="offset:current_a").calibration
    calibration.save(tmp_path / "cal.json")
    loaded = ironout.Calibration.load(tmp_path / "cal.json")
    assert np.array_equal(loaded.apply(hidden), calibration.apply(hidden))
    corrected = loaded.apply(hidden.mag, t=hidden.t, current_a=hidden["current_a"])
    assert corrected.shape == (len(hidden), 3) and np.array_equal(corrected, calibration.apply(hidden))
    assert loaded.residual(hidden).std() < 0.3
    with pytest.raises(IronoutError, match="current_a"):
        loaded.apply(hidden.mag)
    later = ironout.simulate(seed=1, recording=2, effects="offset:current_a=5")
    assert loaded.check(later).good
    # On top of an earlier calibration a short log is enough.
    short = {name: values[:400] for name, values in later.to_dict().items()}
    assert not ironout.fit(short, add="offset:current_a").accepted
    assert ironout.fit(short, add="offset:current_a", prior=loaded).accepted
    assert ironout.fit(short, add="offset:current_a", prior=tmp_path / "cal.json").accepted


def test_parameters_of_autopilots_come_back(hidden, tmp_path):
    calibration = ironout.fit(hidden, add="offset:current_a").calibration
    assert calibration.effects
    before = np.linalg.norm(calibration.apply(hidden), axis=1)
    for form, read, number in (
        ("px4", ironout.Calibration.from_px4, 2),
        ("ardupilot", ironout.Calibration.from_ardupilot, 1),
        ("ardupilot", ironout.Calibration.from_ardupilot, 3),
    ):
        file = tmp_path / f"{form}{number}.params"
        calibration.export(form, file, number=number)
        with pytest.raises(IronoutError, match="current="):
            read(file, number, field_ut=calibration.field_ut)
        again = read(file, number, field_ut=calibration.field_ut, current="current_a")
        # Their matrix is symmetric: the magnitude is the same, and the direction but for a rotation.
        assert np.abs(np.linalg.norm(again.apply(hidden), axis=1) - before).max() < 1e-4
        assert np.array_equal(again.matrix, again.matrix.T) and again.effects == ["offset:current_a"]
        with pytest.raises(IronoutError, match="number="):
            read(file, 1 if number != 1 else 2, field_ut=50)


def test_px4_in_a_turned_mounting(clean, tmp_path):
    file = tmp_path / "turned.params"
    lines = {"XOFF": 0.1, "YOFF": -0.2, "ZOFF": 0.3, "XSCALE": 1.1, "YSCALE": 0.9, "ZSCALE": 1.0, "XODIAG": 0.05, "ROT": 2}
    file.write_text("".join(f"1\t1\tCAL_MAG0_{name}\t{value}\t9\n" for name, value in lines.items()))
    # Yaw 90 degrees: x of the body is −y of the sensor, y of the body its x.
    turned = ironout.Calibration.from_px4(file, field_ut=50)
    assert np.allclose(turned.offset_ut, [20, 10, 30])
    assert np.allclose(turned.matrix, [[0.9, -0.05, 0], [-0.05, 1.1, 0], [0, 0, 1]])
    file.write_text(file.read_text().replace("CAL_MAG0_ROT\t2", "CAL_MAG0_ROT\t100"))
    with pytest.raises(IronoutError, match="not a numbered mounting"):
        ironout.Calibration.from_px4(file, field_ut=50)


def test_frames_and_html(clean):
    fit = ironout.fit(clean)
    frame = fit.to_frame().set_index("parameter")
    assert frame.loc["offset_ut[1]", "value"] == fit.offset_ut[1]
    assert "ACCEPTED" in repr(fit) and "ACCEPTED" in fit._repr_html_()
    assert "µT" in fit.calibration._repr_html_()
    check = fit.calibration.check(clean)
    assert check.good and len(check.to_frame()) == 1 and "GOOD" in check._repr_html_()
    assert len(clean.to_frame()) == len(clean) and clean._repr_html_().startswith("<pre>")


def test_plots(clean, hidden, tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    ironout.fit(clean).plot().savefig(tmp_path / "fit.png")
    diagnosis = ironout.diagnose(hidden)
    axes = diagnosis.plot()
    heights = [bar.get_height() for bar in axes.patches]
    assert diagnosis.steps[0].rms_ut in heights and "µT" in axes.get_ylabel()
    line = next(one for one in diagnosis.plot_residual("current_a").lines if one.get_label() == "mean")
    assert len(line.get_xdata()) >= 10
    diagnosis.plot_sphere().figure.savefig(tmp_path / "sphere.png")
    plt.close("all")
    assert (tmp_path / "fit.png").stat().st_size > 10_000


def test_the_plot_of_the_offset_over_time_shows_a_drift(clean, tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    drift_ut = 4.0
    columns = clean.to_dict()
    columns["mx_ut"] = clean["mx_ut"] + drift_ut * (clean.t / clean.t[-1] - 0.5)
    for table, slope in ((clean, 0.0), (columns, drift_ut / clean.t[-1])):
        axes = ironout.fit(table).plot_wander()
        lines = {bars.get_label(): bars.lines[0] for bars in axes.containers}
        assert set(lines) == set("xyz") and "µT" in axes.get_ylabel()
        slopes = {name: np.polyfit(*line.get_data(), 1)[0] for name, line in lines.items()}
        # The matrix of the fit is near one, within some percent.
        assert abs(slopes["x"] - slope) < 0.02, slopes
        assert max(abs(slopes["y"]), abs(slopes["z"])) < 0.03, slopes
        axes.figure.savefig(tmp_path / "wander.png")
    # A board that hardly turns has no directions to tell an offset by.
    still = {name: values[:60] for name, values in clean.to_dict().items()}
    still.update((name, still[name] * 0 + 20 + 0.01 * np.arange(60)) for name in ("mx_ut", "my_ut", "mz_ut"))
    from ironout import _plots

    mag = np.column_stack([still[name] for name in ("mx_ut", "my_ut", "mz_ut")])
    assert not _plots.wander(still["t_s"], mag, mag[:, 0] * 0, "t_s").containers
    plt.close("all")


def test_progress_is_called_and_other_threads_run(hidden):
    calls, beats = [], []
    done = threading.Event()

    def beat():
        while not done.is_set():
            beats.append(time.monotonic())
            time.sleep(0.01)

    thread = threading.Thread(target=beat)
    thread.start()
    long = ironout.simulate(seed=1, seconds=600, effects="offset:current_a=5")
    began = time.monotonic()
    ironout.diagnose(long, progress=lambda stage, seconds: calls.append((stage, seconds)))
    took = time.monotonic() - began
    done.set()
    thread.join()
    assert took > 0.2, "too fast to be seen"
    assert calls and calls[0][0] == "studying" and calls == sorted(calls, key=lambda call: call[1])
    during = [at for at in beats if at > began]
    assert len(during) > took / 0.05, "the lock was held"
    with pytest.raises(ZeroDivisionError):
        ironout.diagnose(long, progress=lambda stage, seconds: 1 / 0)


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_an_interrupt_ends_a_long_study():
    code = (
        "import ironout\n"
        "log = ironout.simulate(seconds=20000, effects=['offset:current_a=5', 'gain:temp_c=5'])\n"
        "print('ready', flush=True)\n"
        "try:\n    ironout.diagnose(log)\n    print('done', flush=True)\n"
        "except KeyboardInterrupt:\n    print('interrupted', flush=True)\n"
        "import os; os._exit(0)\n"
    )
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    time.sleep(0.5)
    began = time.monotonic()
    child.send_signal(signal.SIGINT)
    assert child.stdout.readline() == "interrupted\n"
    assert time.monotonic() - began < 2
    child.wait()


def test_sums_of_parts_are_those_of_the_whole(clean):
    counts = np.round(clean.mag / 0.1).astype(np.int16)
    whole = ironout.Moments(counts)
    parts = [ironout.Moments(part) for part in np.array_split(counts, 13)]
    order = np.random.default_rng(1).permutation(13)
    merged = ironout.Moments()
    for place in order:
        merged = merged + pickle.loads(pickle.dumps(parts[place]))
    assert merged == whole and merged.count == len(counts)
    scale = (0.1, 0.1, 0.1)
    assert merged.fit_json(scale) == whole.fit_json(scale)
    with pytest.raises(IronoutError, match="too few|TooFew|samples"):
        ironout.Moments().fit_json(scale)
    with pytest.raises(IronoutError, match="not sums"):
        ironout.Moments.from_sums(["1"] * 35 + ["2"])


def test_report_writes_the_page(clean_file, tmp_path):
    program = os.environ.get("IRONOUT_PROGRAM") or pytest.skip("IRONOUT_PROGRAM names no program")
    page = tmp_path / "page.html"
    try:
        ironout.report(clean_file, page, program=program)
    except IronoutError as error:
        # A program without the page says how to build one with it.
        assert "--features page" in str(error) and not page.exists()
    else:
        assert page.read_text(encoding="utf-8").lstrip().lower().startswith("<!doctype html")


def test_the_stubs_name_what_there_is():
    import ast
    import pathlib

    from ironout import _ironout

    stubs = ast.parse((pathlib.Path(ironout.__file__).parent / "_ironout.pyi").read_text(encoding="utf-8"))
    assert (pathlib.Path(ironout.__file__).parent / "py.typed").exists()
    named = {node.name: node for node in stubs.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    there = {name for name in dir(_ironout) if not name.startswith("_")}
    assert there == {name for name in named if not name.startswith("_")}
    for name, node in named.items():
        if isinstance(node, ast.ClassDef) and name != "IronoutError":
            methods = {one.name for one in node.body if isinstance(one, ast.FunctionDef)}
            methods |= {one.target.id for one in node.body if isinstance(one, ast.AnnAssign)}
            own = {one for one in vars(getattr(_ironout, name)) if not one.startswith("_")}
            assert own <= methods, (name, own - methods)


def test_report_says_what_it_needs(clean_file, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", os.fspath(tmp_path))
    with pytest.raises(IronoutError, match="not on the path. Fix: cargo install"):
        ironout.report(clean_file, tmp_path / "page.html")
