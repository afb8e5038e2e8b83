#!/usr/bin/python3
"""Every page of the project: links and pictures lead somewhere, commands name scripts and scenes that are there and are
understood in dry form, and figures in tables are those of the csv files that they come from."""

import csv
import re
import shlex
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from program import WITHOUT, ProgramTest, main

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "postprocess/results"
FOLDERS = (".", "inputs", "inputs/tutorial", "postprocess", "postprocess/results", "jobs", "jobs/cluster", "tests/extending")
PAGES = sorted(page for folder in FOLDERS for page in (ROOT / folder).glob("*.md")) + sorted(
    (ROOT / "src").glob("*/README.md"))


def without_code(text):
    return re.sub(r"`[^`]*`", "", re.sub(r"```.*?```", "", text, flags=re.S))


def anchors(page):
    """As GitHub makes them of headings."""
    headings = re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", page.read_text(), flags=re.S), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def commands(page):
    """Lines of indented blocks, their comments left out."""
    for line in page.read_text().splitlines():
        if line.startswith("    ") and re.match(r" +(jobs/|build/release/trevi |postprocess/|sbatch |trevi-view )", line):
            yield shlex.split(line, comments=True)


class Pages(ProgramTest):
    def test_pages_of_the_code_are_short(self):
        for page in [ROOT / "ARCHITECTURE.md", ROOT / "CONTRIBUTING.md", *(ROOT / "src").glob("*/README.md")]:
            with self.subTest(page=page.relative_to(ROOT)):
                self.assertLessEqual(len(page.read_text().splitlines()), 150)

    def test_lines_are_short(self):
        """At most 120 characters; rows of tables and pictures cannot be broken."""
        for page in (page for page in PAGES if page.name not in ("CHANGELOG.md", "LICENSE.md")):
            lines = page.read_text().splitlines()
            with self.subTest(page=page.relative_to(ROOT)):
                self.assertEqual([line for line in lines if len(line) > 120 and not line.startswith(("|", "!["))], [])

    def test_links_and_pictures_lead_somewhere(self):
        self.assertGreater(len(PAGES), 12)
        for page in PAGES:
            for target in re.findall(r"\]\(([^)\s]+)\)", without_code(page.read_text())):
                if re.match("https?:", target):
                    continue
                path, _, anchor = target.partition("#")
                file = (page.parent / path).resolve() if path else page
                with self.subTest(page=page.name, link=target):
                    self.assertTrue(file.exists())
                    if anchor and file.suffix == ".md":
                        self.assertIn(anchor, anchors(file))

    def test_every_picture_is_shown(self):
        shown = {(page.parent / target).resolve() for page in PAGES
                 for target in re.findall(r"\]\(([^)\s]+\.png)\)", page.read_text())}
        self.assertEqual({path for path in RESULTS.rglob("*.png")} - shown, set())

    def test_commands_name_what_is_there(self):
        found = 0
        for page in PAGES:
            for words in commands(page):
                with self.subTest(page=page.name, command=" ".join(words)):
                    for word in words:
                        if re.match(r"(jobs|inputs|postprocess|tests)/[\w./]+$", word):
                            if word != "inputs/tutorial/mine.toml":
                                self.assertTrue((ROOT / word).exists(), word)
                                found += 1
        self.assertGreater(found, 20)

    def test_runs_are_understood(self):
        """What follows -- in a call of jobs/run.sh, and calls of trevi itself, in dry form."""
        tried = set()
        for page in PAGES:
            for words in commands(page):
                if words[0] == "jobs/run.sh":
                    scene, more = words[1], words[words.index("--") + 1:] if "--" in words else []
                elif words[0] == "build/release/trevi":
                    scene, more = words[1], words[2:]
                else:
                    continue
                if scene == "SCENE" or "--preview" in more or (scene, *more) in tried:
                    continue
                tried.add((scene, *more))
                with self.subTest(page=page.name, command=" ".join(words)):
                    result = self.run_trevi(1, ROOT / scene, *more, "--dry-run")
                    missing = any(f"TREVI_WITH_{part}=ON" in result.stderr for part in WITHOUT)
                    self.assertEqual(result.returncode, 2 if missing else 0, result.stderr)
        self.assertGreater(len(tried), 6)

    def test_scripts_tell_their_usage(self):
        for script in sorted((ROOT / "jobs").glob("*.sh")):
            with self.subTest(script.name):
                told = subprocess.run([script, "--help"], capture_output=True, text=True, timeout=60, check=True).stdout
                self.assertIn("usage:", told)
                self.assertIn(script.name, (ROOT / "jobs/README.md").read_text())


def table(page, head):
    """Rows of the table that begins with this line, as lists of cells without stars."""
    lines = (RESULTS / page).read_text().splitlines()
    first = next(number for number, line in enumerate(lines) if line.startswith(head)) + 2
    last = next(number for number in range(first, len(lines)) if not lines[number].startswith("|"))
    return [[cell.strip(" *") for cell in line.strip("|").split("|")] for line in lines[first:last]]


def rows_of(name):
    with open(RESULTS / name, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


class Claims(unittest.TestCase):
    def test_the_same_bits_are_not_promised_of_anderson(self):
        for page in ("README.md", "inputs/README.md"):
            claims = [" ".join(part.split()) for part in re.split(r"\n\n|\n\|", (ROOT / page).read_text())]
            self.assertTrue([claim for claim in claims if "bits" in claim and "anderson" in claim], page)

    def test_thin_tanks_and_formats_are_in_the_reference(self):
        text = " ".join((ROOT / "inputs/README.md").read_text().split())
        for words in ("### Two dimensions", "at least one kernel radius wide in each axis, which is two spacings",
                      "lines `time pitch length`", "HDF5 with `/particles/position` (N × 3",
                      "`/particles/id` (N, integers"):
            self.assertIn(words, text)


class Figures(unittest.TestCase):
    def assert_written(self, said, value):
        """Said to as many decimals as it is written with; a minus may be a real one."""
        number = said.split()[0].replace("\N{MINUS SIGN}", "-").replace(",", "")
        decimals = len(number.partition(".")[2])
        self.assertAlmostEqual(float(number), float(value), delta=0.501 * 10**-decimals, msg=f"{said} for {value}")

    def test_waves(self):
        real = {(row["layers"], row["ratio"], row["amplitude"]): row for row in rows_of("water.csv")
                if row["group"] == "waves" and re.fullmatch(r"\d+ layers, 4 m, A .*, 1/60 s", row["name"])}
        told = table("water.md", "| layers | h, spacings |")
        self.assertEqual(len(told), 9)
        for layers, ratio, *cells in told:
            for amplitude, cell in zip(("1", "0.5", "0.25"), cells):
                with self.subTest(layers=layers, ratio=ratio, amplitude=amplitude):
                    period, loss = cell.replace("*", "").split(",")
                    self.assert_written(period, real[layers, ratio, amplitude]["period_ratio"])
                    self.assert_written(loss, 100 * float(real[layers, ratio, amplitude]["loss_per_half"]))

    def test_water_in_short(self):
        rows = rows_of("water.csv")
        text = " ".join((RESULTS / "README.md").read_text().split())
        passed, cases = re.search(r"(\d+) of (\d+) cases whose right answer", text).groups()
        self.assertEqual((int(passed), int(cases)), (sum(row["verdict"] == "pass" for row in rows), len(rows)))
        tanks = [row for row in rows if re.fullmatch(r"[124]0 layers, 4 m, A .*, 1/60 s", row["name"])]
        said = re.search(r"swing in ([\d.]+) to ([\d.]+) of .* at h = 2 spacings \(([\d.]+) to ([\d.]+) at 2.5, "
                         r"([\d.]+) to ([\d.]+) at 3;", text).groups()
        for (low, high), ratio in zip(zip(said[::2], said[1::2]), ("2", "2.5", "3")):
            periods = [float(row["period_ratio"]) for row in tanks if row["ratio"] == ratio]
            self.assertEqual(len(periods), 9)
            self.assert_written(low, min(periods))
            self.assert_written(high, max(periods))
        losses = [100 * float(row["loss_per_half"]) for row in tanks if row["ratio"] == "2"]
        low, high = re.search(r"lose ([\u2212\d.]+) to ([\d.]+) %", text).groups()
        self.assert_written(low, min(losses))
        self.assert_written(high, max(losses))
        pools = [float(row["kinetic_per_mass"]) for row in rows if row["group"] == "pools" and row["ratio"] == "2"]
        low, high = re.search(r"stays where it is, at (\S+) to (\S+) m²/s²", text).groups()
        self.assert_rounds_to(low, min(pools))
        self.assert_rounds_to(high, max(pools))

    def test_scaling(self):
        real = {(row["study"], row["case"], row["ranks"], row["threads"]): row for row in rows_of("scaling.csv")}
        cases = {"strong, 96,000 in all": "96k", "strong, 1 million in all": "million", "weak, 96,000 a core": "96k",
                 "weak, 500,000 a core": "million"}
        columns = ["runs", "ms_per_step_median", "ms_per_step_fastest", "efficiency_median", "efficiency_fastest",
                   "wait_percent_median", "wait_percent_least", "messages_per_step"]
        told = table("scaling.md", "| study | ranks x threads |")
        self.assertEqual(len(told), 12)
        for study, shape, *cells in told:
            row = real[study.split(",")[0], cases[study], *shape.split(" x ")]
            for column, cell in zip(columns, cells):
                with self.subTest(study=study, shape=shape, column=column):
                    self.assert_written(cell, row[column])
            self.assert_written(cells[-1], float(row["bytes_per_step"]) / 1e6)

    def test_messages(self):
        real = {(row["case"], row["ranks"]): row for row in rows_of("scaling.csv") if row["study"] == "counted"}
        told = table("scaling.md", "| case | ranks | steps | messages by formula |")
        self.assertEqual(len(told), 8)
        for case, ranks, steps, by_formula, messages, bytes_by_formula, sent, _ in told:
            with self.subTest(case=case, ranks=ranks):
                self.assertEqual((by_formula, bytes_by_formula), (messages, sent))
                self.assert_written(str(int(messages) / int(steps)), real[case, ranks]["messages_per_step"])
                self.assert_written(str(int(sent) // int(steps)), real[case, ranks]["bytes_per_step"])

    def performance(self):
        """{(case, quantity): value}, of one processor."""
        rows = rows_of("performance.csv")
        self.assertEqual(len({row["processor"] for row in rows}), 1)
        return {(row["case"], row["quantity"]): float(row["value"]) for row in rows}

    def test_limit(self):
        real = self.performance()
        told = table("performance.md", "| | step, ms | parts, ms |")
        self.assertEqual([row[0] for row in told], ["AVX-512", "AVX2", "SSE4"])
        columns = ["step", "parts", "search", "density_spiky", "delta_spiky", "coarse", "step over parts", "coarse percent"]
        for name, *cells in told:
            for column, cell in zip(columns, cells, strict=True):
                with self.subTest(name=name, column=column):
                    self.assert_written(cell, real["limit, " + name, column])

    def test_steps(self):
        real = self.performance()
        cases = {"96,000 at rest": "rest", "96,000 sloshing": "slosh", "vorticity and XSPH": "filters",
                 "falling cube": "cube"}
        columns = ["ms per step, median", "ms per step, fastest", "simulated s per wall s"]
        told = table("performance.md", "| ms per step | median of five steps |")
        self.assertEqual(len(told), 8)
        for name, *cells in told:
            run = f"{next(cases[case] for case in cases if name.startswith(case))}_np{name.split()[-2]}"
            for column, cell in zip(columns, cells):
                with self.subTest(name=name, column=column):
                    self.assert_written(cell, real[run, column])

    def test_speed_in_short(self):
        real = self.performance()
        pair, times, at_rest = re.search(
            r"([\d.]+) ns per pair on one core; 96,000 particles that slosh in ([\d.]+) times real time on two, at rest "
            r"([\d.]+)", (ROOT / "README.md").read_text()).groups()
        self.assert_written(pair, real["ns per pair, AVX-512", "density_spiky"])
        self.assert_written(times, real["slosh_np2", "simulated s per wall s"])
        self.assert_written(at_rest, real["rest_np2", "simulated s per wall s"])
        told = dict(table("README.md", "| | Trevi |"))
        passes = told["lambda / delta, ns per pair, one core"].split(";")[0].split(" / ")
        self.assert_written(passes[0], real["ns per pair, AVX-512", "density_spiky"])
        self.assert_written(passes[1], real["ns per pair, AVX-512", "delta_spiky"])
        steps = re.findall(r"[\d.]+", told["whole step, 96,000 at rest, one rank"])
        real_time = re.findall(r"[\d.]+", told["real time, 96,000 at rest, dt = 1/30 s, 2 ranks"])
        for k, case in enumerate(("rest", "slosh", "filters")):
            self.assert_written(steps[k], real[f"{case}_np1", "ms per step, median"])
            self.assert_written(real_time[k], real[f"{case}_np2", "simulated s per wall s"])

    def test_tables_are_made_of_their_csv_files(self):
        """Of surfaces, vessels, leaks, pipes, vortices and tanks; that they would be found out is tried, too."""
        script = RESULTS.parent / "result_tables.py"
        subprocess.run([script, "--check"], check=True, timeout=60)
        with tempfile.TemporaryDirectory() as folder:
            shutil.copytree(RESULTS, Path(folder) / "results", ignore=shutil.ignore_patterns("*.png", "tutorial"))
            copy = shutil.copy(script, folder)
            page = Path(folder) / "results/pipe.md"
            page.write_text(re.sub(r"\| \d\.\d+ \|", "| 9.999 |", page.read_text(), count=1))
            told = subprocess.run([copy, "--check"], capture_output=True, text=True, timeout=60, check=False)
            self.assertEqual(told.returncode, 1)
            self.assertIn("pipe.md", told.stderr)
            subprocess.run([copy], check=True, timeout=60)
            self.assertEqual(page.read_text(), (RESULTS / "pipe.md").read_text())

    def test_each_page_has_a_date_a_version_and_a_processor(self):
        for page in RESULTS.glob("*.md"):
            text = page.read_text()
            if page.name in ("README.md", "report_figures.md", "checking.md", "defaults.md"):  # of pages, pictures and machines
                continue
            with self.subTest(page.name):
                for what in (r"\d{1,2} [A-Z][a-z]+ 202\d", r"\b[0-9a-f]{7}\b|1\.0\.0 with", "EPYC|Xeon|processor"):
                    self.assertTrue(re.search(what, text), what)

    def test_error_against_run_time(self):
        real = self.compressions()
        told = table("error_against_run_time.md", "| compression, seconds |")
        scenes = {"falling cube": "cube", "column, 40 layers": "column", "dam break": "dam", "fountain": "fountain"}
        self.assertEqual([row[0] for row in told], list(scenes))
        found = {scene for scene, _, _ in real}
        for name, report4, default3, _, _, report8, default8, _, _ in told:
            scene = next(one for one in found if one.startswith(scenes[name]))
            keys = [("report's Jacobi", 4), ("default", 3), ("report's Jacobi", 8), ("default", 8)]
            for cell, key in zip((report4, default3, report8, default8), keys):
                with self.subTest(scene=name, key=key):
                    self.assert_rounds_to(cell.split(",")[0], real[scene, *key])

    def compressions(self):
        """{(scene, method, iterations): mean compression}."""
        with open(RESULTS / "error_against_run_time.csv", newline="", encoding="utf-8") as file:
            return {(row["scene"], row["method"], int(row["iterations"])): float(row["compression_mean"])
                    for row in csv.DictReader(file)}

    def assert_rounds_to(self, said, value):
        digits = len(said.partition("e")[0].replace(".", "").lstrip("0"))
        self.assertAlmostEqual(float(said) / value, 1, delta=0.51 * 10 ** (1 - digits), msg=f"{said} for {value}")

    def test_readme_has_the_packages_of_the_scripts(self):
        setup = (ROOT / "jobs/setup.sh").read_text()
        lists = re.findall(r"^(?:trevi|test)_packages=\((.*?)\)", setup, re.M | re.S)
        told, = re.findall(r"^    apt-get install --no-install-recommends (.*?)\n\n", (ROOT / "README.md").read_text(),
                           re.M | re.S)
        self.assertEqual(told.replace("\\", " ").split(), " ".join(lists).split())

    def test_readme(self):
        real = self.compressions()
        error, = re.findall(r"falling cube: ([\d.]+) % by default, ([\d.]+) %", (ROOT / "README.md").read_text())
        self.assert_rounds_to(error[0], 100 * real["cube", "default", 3])
        self.assert_rounds_to(error[1], 100 * real["cube", "report's Jacobi", 4])

    def test_error_table(self):
        real = self.compressions()
        text = (RESULTS / "README.md").read_text()
        for words, scene in (("falling cube, 20³", "cube"), ("fountain", "fountain")):
            row, = re.findall(rf"^\| {re.escape(words)} \| ([\d.]+) % / ([\d.]+) % \| ([\d.]+) % / ([\d.]+) %", text,
                              re.MULTILINE)
            keys = [("report's Jacobi", 4), ("report's Jacobi", 8), ("default", 3), ("default", 8)]
            for said, (method, iterations) in zip(row, keys):
                with self.subTest(scene=scene, method=method, iterations=iterations):
                    self.assert_rounds_to(said, 100 * real[scene, method, iterations])

    def test_stability(self):
        with open(RESULTS / "stability.csv", newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        text = " ".join((RESULTS / "README.md").read_text().split())
        said = re.search(r"Of (\d+) stress cases.*?default is stable in (\d+);[^;]*preset in (\d+)", text, re.S)
        stable = {name: sum(row["preset"] == name and row["verdict"] == "stable" for row in rows)
                  for name in ("default", "report")}
        cases = len({(row["group"], row["case"]) for row in rows if row["preset"] == "default"})
        self.assertEqual([int(number) for number in said.groups()], [cases, stable["default"], stable["report"]])


if __name__ == "__main__":
    main()
