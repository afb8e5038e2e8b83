"""What tests of bad input share: a good scene of which each case changes a line, and how a case is refused."""

from collections import Counter
from concurrent.futures import ThreadPoolExecutor

from program import ProgramTest

# The good scene, by line: each case replaces one line, so the number of the bad line is known.
GOOD = ["[domain]", "min = [0, 0, 0]", "max = [2, 1, 1]", "[fluid]", "spacing = 0.1", "kernel_radius = 0.2",
        "[[particles]]", "type = 'block'", "min = [0, 0, 0]", "max = [1, 1, 0.5]", "[time]", "dt = 0.01", "end = 0.02",
        "[output.series]", "every_steps = 1"]


def scene_with(line, text):
    return "\n".join([*GOOD[:line - 1], text, *GOOD[line:]]) + "\n"


def scene_of_file():
    return "\n".join([*GOOD[:7], "type = 'file'", "path = 'cloud.h5'", *GOOD[10:]]) + "\n"


class RefusedTest(ProgramTest):
    tried = Counter()  # ranks -> cases

    @classmethod
    def tearDownClass(cls):
        print("bad scenes, files and commands:", ", ".join(f"{cls.tried[n]} on {n} ranks" for n in sorted(cls.tried)))

    def refuse(self, name, text, arguments, words, ranks, prepare=None):
        """Runs the program on one bad case in a folder of its own and returns what it did wrong, if anything."""
        folder = self.folder / f"{name} on {ranks}"
        folder.mkdir()
        (folder / "scene.toml").write_text(text)
        if prepare:
            prepare(folder)
        before = self.contents(folder)
        result = self.run_trevi(ranks, *arguments, folder=folder)
        wrong = [f"'{word}' is not in the message" for word in words if word not in result.stderr]
        if result.returncode != 2:
            wrong.append(f"exit code {result.returncode}")
        if result.stderr.count(words[0]) > 1:
            wrong.append("printed more than once")
        if self.contents(folder) != before:
            wrong.append("something was written")
        return f"{folder.name}: {', '.join(wrong)}\n{result.stderr}" if wrong else None

    def assert_all_refused(self, cases, rank_counts=(1, 2)):
        """Several at a time, as most of a refusal is mpirun's waiting."""
        with ThreadPoolExecutor(4) as pool:
            runs = [pool.submit(self.refuse, *case[:4], ranks, *case[4:]) for case in cases for ranks in rank_counts]
        self.tried.update({ranks: len(cases) for ranks in rank_counts})
        failures = [run.result() for run in runs if run.result()]
        self.assertFalse(failures, "\n".join(failures))
