"""The same digits as the command line, in every key of its JSON."""

import ironout
from conftest import of_the_log, without_names


def test_fit(program, clean, clean_file):
    told = program("fit", clean_file)
    assert ironout.fit(clean_file).data == of_the_log(told)
    assert without_names(ironout.fit(clean).data) == without_names(told)
    told = program("fit", clean_file, "--field", "50", "--method", "trace")
    assert ironout.fit(clean_file, field_ut=50, method="trace").data == of_the_log(told)


def test_diagnose_and_effects(program, hidden, hidden_file):
    told = program("diagnose", hidden_file)
    assert of_the_log(ironout.diagnose(hidden_file).data) == of_the_log(told)
    assert without_names(ironout.diagnose(hidden).data) == without_names(told)
    assert told["verdict"] == "missing"
    told = program("fit", hidden_file, "--add", "offset:current_a")
    assert ironout.fit(hidden_file, add="offset:current_a").data == of_the_log(told)


def test_calibration_file_and_check(program, clean_file, hidden_file, tmp_path):
    cal, own = tmp_path / "cal.json", tmp_path / "own.json"
    program("fit", clean_file, "-o", cal)
    ironout.fit(clean_file).calibration.save(own)
    assert own.read_text() == cal.read_text()
    assert ironout.check(clean_file, cal).data == program("check", clean_file, "--cal", cal)
    assert ironout.check(hidden_file, cal).data == program("check", hidden_file, "--cal", cal, status=1)


def test_export_and_simulate(program, clean_file, tmp_path):
    calibration = ironout.fit(clean_file).calibration
    cal = tmp_path / "cal.json"
    calibration.save(cal)
    assert calibration.export("c") == program("export", cal, "--as", "c")["text"]
    told = program("export", cal, "--as", "px4", "--number", "0", "--device-id", "396825", "--log", clean_file)["text"]
    assert calibration.export("px4", number=0, device_id=396825, log=clean_file) == told
    log = tmp_path / "log.csv"
    truth = program("simulate", "-o", log, "--seed", "3", "--seconds", "20", "--effect", "lag=4")["truth"]
    simulated = ironout.simulate(seed=3, seconds=20, effects=["lag=4"])
    assert simulated.truth == truth
    read = ironout.read(log)
    assert all((read[name] == simulated[name]).all() for name in ("t_s", "mx_ut", "my_ut", "mz_ut", "ax_mps2"))


def test_apply(program, clean_file, tmp_path):
    calibration = ironout.fit(clean_file).calibration
    cal = tmp_path / "cal.json"
    calibration.save(cal)
    after = program("apply", clean_file, "--cal", cal)["after"]["rms_ut"]
    residual = calibration.residual(clean_file)
    # The program leaves out repeated readings, of which this log has one or two.
    assert abs((residual**2).mean() ** 0.5 - after) < 1e-3 * after
