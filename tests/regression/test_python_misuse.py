#!/usr/bin/python3
"""What a script does wrong, on all ranks or on one alone: each rank is told, none waits for ever, none breaks down."""

from program import INPUTS, main
from python_module import TANK, ModuleTest

TOLD = """
    mine = lattice[trevi.rank::trevi.size]
    last = trevi.rank == trevi.size - 1
    def told(kind, work):
        try:
            work()
        except kind as error:
            return str(error).splitlines()[0]
        return "nothing"
    def tell(words):  # mpirun mixes long lines of several ranks
        with open(f"told_{trevi.rank}.txt", "w") as file:
            file.write(words)
"""


class Misuse(ModuleTest):
    def lines(self, ranks, script, *arguments):
        self.run_fine(ranks, (TANK, TOLD, script), *arguments)
        return [(self.folder / f"told_{rank}.txt").read_text() for rank in range(ranks)]

    def assert_has(self, line, words):
        parts = line.split(" | ")
        self.assertEqual(len(parts), len(words), line)
        for part, word in zip(parts, words):
            self.assertIn(word, part)

    def test_a_callback_of_one_rank_ends_the_run_on_all(self):
        script = """
            solver = trevi.make_solver(settings, mine)
            def fails(one):
                if last and one.steps == 3:
                    raise KeyError("own")
            try:
                solver.run(steps=5, callback=fails)
            except KeyError as error:
                told_of_failure = "own exception"
            except trevi.RunError as error:
                told_of_failure = str(error)
            failed_after = solver.steps
            solver.run(steps=5, callback=lambda one: last and one.steps == 5)
            stopped_after = solver.steps
            solver.run(steps=2, callback=None if last else lambda one: False)
            tell(f"{told_of_failure}, {failed_after}, {stopped_after}, {solver.steps}")
        """
        self.assertEqual(self.lines(1, script), ["own exception, 3, 5, 7"])
        other = "run(): the callback failed on another rank, 3, 5, 7"
        self.assertEqual(self.lines(3, script), [other, other, "own exception, 3, 5, 7"])

    def test_steps_of_a_run(self):
        script = """
            solver = trevi.make_solver(settings, mine)
            wrong = [dict(steps=-1), dict(steps=1.5), dict(until=float("nan")), dict(until="1"), dict()]
            all = [told(trevi.InputError, lambda: solver.run(**one)) for one in wrong]
            all.append(told(trevi.InputError, lambda: solver.run(steps=-1 if last else 2)))
            all.append(told(trevi.InputError, lambda: solver.run(steps=3 if last else 2)))
            assert solver.steps == 0
            solver.run(until=np.float32(2 * solver.dt))
            solver.run(until=1e300, callback=lambda one: one.steps == 3)
            assert solver.steps == 3
            tell(" | ".join(all))
        """
        for line in self.lines(2, script):
            words = ("steps must be", "steps must be", "until must be", "until must be", "give until or steps", "steps",
                     "differ between ranks")
            self.assert_has(line, words)

    def test_a_change_that_fails_on_one_rank_is_none_on_all(self):
        script = """
            solver = trevi.make_solver(settings, mine)
            def change(spoil):
                with solver.change():
                    solver.velocities[:] = 1
                    spoil()
            def fail():
                if last:
                    raise KeyError("own")
            def misshape():
                if last:
                    solver.velocities = solver.velocities[1:]
            def halve():
                if last:
                    solver.ids = solver.ids + 0.5
            all = [told((trevi.RunError, KeyError), lambda: change(fail))]
            all += [told(trevi.InputError, lambda: change(spoil)) for spoil in (misshape, halve)]
            assert len(solver.ids) and (solver.velocities == 0).all()
            solver.step()
            tell(" | ".join(all))
        """
        for ranks in (1, 2):
            *others, failed = self.lines(ranks, script)
            self.assert_has(failed, ("own", "a row for each particle", "whole numbers from 0"))
            for line in others:
                self.assert_has(line, ("failed on another rank", "a row for each particle", "whole numbers from 0"))

    def test_input_that_cannot_be_is_refused_on_all_ranks(self):
        script = """
            class Push:
                def __init__(self, fastest):
                    self.fastest = fastest
                def __call__(self, water, step):
                    pass
            n = len(mine)
            good = np.arange(n) * trevi.size + trevi.rank
            masked = np.ma.masked_array(mine, mask=mine > 1)
            wrong = [dict(positions=mine[:, :2]), dict(positions=mine + 1j), dict(positions=mine.astype(str)),
                     dict(positions=masked), dict(positions=[[0, 1, 2], [3]]), dict(velocities=mine[:, 0]),
                     dict(ids=good + 0.5), dict(ids=good - 10000), dict(ids=good + 2**62),
                     dict(ids=good.astype(np.uint64) + np.uint64(2**63)), dict(ids=good * float("nan")),
                     dict(ids=good[1:]), dict(forcings=[5]), dict(forcings=lambda water, step: None),
                     dict(forcings=[Push("x")]), dict(forcings=[Push(float("nan"))]), dict(forcings=[Push(-1)]),
                     dict(rows=0), dict(rows=-1), dict(rows="x")]
            fine = dict(positions=mine, ids=good, forcings=[Push(1)], rows=2)
            def make(here, given):
                return trevi.make_solver(settings, **(fine | given if here else fine))
            all = [told(trevi.InputError, lambda: make(here, one)) for here in (True, last) for one in wrong]
            all.append(told(trevi.InputError, lambda: trevi.make_solver("x" if last else settings, mine)))
            make(True, dict(ids=good.astype(float))).step()
            make(True, dict(ids=good.astype(np.uint8 if n < 256 else np.uint16), positions=mine.tolist())).step()
            tell(" | ".join(all))
        """
        words = ("(n, 3)", "complex", "real numbers", "masked", "positions", "velocities: must be an array of shape",
                 *["whole numbers from 0"] * 5, "different lengths", *["list of callables"] * 2, *["fastest"] * 3,
                 *["rows"] * 3)
        for ranks in (1, 2):
            for line in self.lines(ranks, script):
                self.assert_has(line, (*words, *words, "settings: must be Settings"))

    def test_what_differs_between_ranks_is_refused_on_all(self):
        script = """
            def make(spoil, **given):
                one = trevi.Settings()
                one.domain.max = [2, 1, 1.5]
                one.obstacles.append(trevi.ObstacleSettings())
                one.obstacles[0].center, one.obstacles[0].radius = [1.8, 0.5, 1.2], 0.1
                if last:
                    spoil(one)
                return trevi.make_solver(one, **(dict(positions=mine) | given))
            def gravity(one):
                one.gravity = [0, 0, -5]
            def obstacle(one):
                one.obstacles[0].center[0] = 1.7
            def precision(one):
                one.density.precision = trevi.Precision.single
            def nothing(one):
                pass
            n = len(mine)
            all = [told(trevi.InputError, lambda: make(one)) for one in (gravity, obstacle, precision)]
            all.append(told(trevi.InputError, lambda: make(nothing, rows=1 if last else 2)))
            all.append(told(trevi.InputError, lambda: make(nothing, ids=None if last else np.arange(n))))
            make(nothing, positions=None if last else mine, rows=np.int64(2) if last else 2).step()
            scene = trevi.read_scene(sys.argv[1])
            all.append(told(trevi.InputError, lambda: trevi.make_solver(scene, None if last else mine)))
            trevi.make_solver(scene).step()
            tell(" | ".join(all))
        """
        words = ("settings.gravity: differs", "settings.obstacles: differs", "settings.density: differs",
                 "rows: differs", "ids: given on some", "positions: given on some")
        for line in self.lines(2, script, INPUTS / "fountain_small.toml"):
            self.assert_has(line, words)

    def test_a_forcing_does_not_use_its_own_solver(self):
        script = """
            def refused(use):
                def wind(water, step):
                    water.ids, water.positions, water.velocities
                    use(solver)
                solver = trevi.make_solver(settings, mine, forcings=[wind])
                words = told(trevi.RunError, solver.step)
                assert solver.steps == 0 and len(solver.ids) == len(mine)
                return words
            def change(one):
                with one.change():
                    pass
            uses = [lambda one: one.step(), lambda one: one.run(steps=1), change, lambda one: one.close(),
                    lambda one: one.positions, lambda one: one.gather_positions()]
            tell(" | ".join(refused(use) for use in uses))
        """
        for ranks in (1, 2):
            for line in self.lines(ranks, script):
                self.assert_has(line, ["within a forcing of the same solver"] * 6)

    def test_another_solver_may_be_used_in_a_forcing(self):
        script = """
            other = trevi.make_solver(settings, mine)
            solver = trevi.make_solver(settings, mine, forcings=[lambda water, step: other.step()])
            solver.run(steps=2)
            tell(f"{solver.steps} {other.steps}")
        """
        self.assertEqual(self.lines(2, script), ["2 2"] * 2)

    def test_a_step_is_not_made_within_a_change(self):
        script = """
            solver = trevi.make_solver(settings, mine)
            with solver.change():
                calls = solver.step, lambda: solver.run(steps=1), solver.close
                all = [told(trevi.InputError, call) for call in calls]
            solver.step()
            tell(" | ".join(all))
        """
        for line in self.lines(2, script):
            self.assert_has(line, ["within \"with solver.change():\""] * 3)

    def test_arrays_that_are_kept_do_no_harm(self):
        script = """
            kept = []
            def keeps(water, step):
                water.velocities[:, 0] = 0.25
                kept.append((water, water.velocities, water.positions, water.ids, water.velocities[:, 1]))
            def run(forcing, after=lambda: None):
                solver = trevi.make_solver(settings, mine, forcings=[forcing])
                for _ in range(3):
                    solver.step()
                    after()
                return solver
            def pushes(water, step):
                water.velocities[:, 0] = 0.25
            def scribble():
                for water, velocities, positions, ids, column in kept:
                    for array in (velocities, positions, ids):
                        assert told(ValueError, lambda: array.__setitem__(0, 7)) != "nothing"
                    assert "during the call" in told(trevi.RunError, lambda: water.velocities)
                    column[:] = 1e9  # a view of a view: its memory is the script's by now
            plain, solver = run(pushes), run(keeps, scribble)
            assert len(kept) >= 3 and (plain.positions == solver.positions).all() and (solver.velocities < 1).all()
            with solver.change():
                changed = solver.velocities
                changed[:] = 0.5
                own = solver.ids = solver.ids.copy()
            assert told(ValueError, lambda: changed.fill(3)) != "nothing" and own.flags.writeable
            assert (solver.velocities == 0.5).all()
            views = solver.positions, solver.velocities, solver.ids
            copies = [view.copy() for view in views]
            solver.close()
            scribble()
            del solver
            rest = [np.full_like(copy, 3) for copy in copies for _ in range(50)]  # takes the memory that was freed
            assert all((view == copy).all() for view, copy in zip(views, copies))
            tell("fine")
        """
        for ranks in (1, 2):
            self.assertEqual(self.lines(ranks, script), ["fine"] * ranks)

    def test_paths_and_booleans_of_numpy_are_taken(self):
        script = """
            from pathlib import Path
            for value in (True, False):
                scene = trevi.read_scene(Path(sys.argv[1]), {"density.coarse_grid": np.bool_(value),
                                                             "output.directory": Path("out") / "there"})
                assert scene.density.coarse_grid is value
                assert '# --set output.directory="out/there"' in scene.text
            settings.output.directory = Path("out") / "here"
            assert settings.output.directory == "out/here"
            settings.output.series = trevi.Schedule(every_steps=1)
            solver = trevi.make_solver(settings, mine)
            solver.step()
            solver.close()
            tell("fine")
        """
        self.lines(2, script, INPUTS / "fountain_small.toml")
        self.assertEqual(len((self.folder / "out/here/series.csv").read_text().splitlines()), 3)


if __name__ == "__main__":
    main()
