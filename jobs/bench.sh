#!/usr/bin/env bash
# usage: jobs/bench.sh [--quick] [--repeats N] [--csv FILE]
#
# Measures how fast Trevi is on this machine, and prints tables:
#   pair loops    ns per pair of each loop and of the search, memory roofline beside (build/bench/.../bench_pairs)
#   falling cube  inputs/falling_cube.toml, 100 steps in single precision, on 1 and 2 ranks
#   limit         inputs/bench_rest.toml with a velocity, so that all rows are swept, on one rank against the sum of its
#                 parts as bench_pairs measures them, on each instruction set of the machine
#   real time     inputs/bench_rest.toml: 96,000 particles, dt = 1/30 s, on 1 and 2 ranks; with a velocity, so that the
#                 water sloshes and all rows are swept; and that with vorticity and XSPH
#   obstacle      the same with a ball far above the water, on 1 rank
#   bodies        the same with ten balls that float, and with ten that stand
#   two ranks     against one, 96,000 and 1 million particles, on a cloud that cuts evenly
#   precision     density curve of the falling cube, single against double, and double with a hardly disturbed start
#   output        checkpoint and VTKHDF frame of 1 million particles against plain writes of the same bytes
# Builds with benchmarks in build/bench; runs go to out/bench. Each run is done N times (default 3) and the fastest is
# shown, as other work on the machine only ever slows one down. --quick leaves out pair loops, million and precision.
# --csv writes steps and limit to FILE, too: postprocess/results/performance.csv is made by it, and the tests compare the
# tables of performance.md with it.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

parse_arguments() {
  quick=no
  repeats=3
  csv=""
  while [[ $# -gt 0 ]]; do
    case "$1" in
      -h | --help) print_help && exit 0 ;;
      --quick) quick=yes && shift ;;
      --repeats) repeats="${2:?--repeats needs a number}" && shift 2 ;;
      --repeats=*) repeats="${1#*=}" && shift ;;
      --csv) csv="$(realpath -m "${2:?--csv needs a file}")" && shift 2 ;;
      --csv=*) csv="$(realpath -m "${1#*=}")" && shift ;;
      *) fail "unknown argument $1; see --help" 2 ;;
    esac
  done
  [[ $repeats =~ ^[1-9][0-9]*$ ]] || fail "--repeats must be a positive number, not '$repeats'" 2
}

build_benchmarks() {
  cmake --preset release -B build/bench -DTREVI_BENCHMARKS=ON -DTREVI_TESTS=OFF >/dev/null
  cmake --build build/bench -j "$(build_jobs)"
}

# Sets all water of inputs/bench_rest.toml in motion. At rest on its lattice nothing of it is swept.
readonly sloshing='particles.0.velocity=[0.3, 0.2, 0.0]'

# run NAME RANKS SCENE STEPS [KEY=VALUE ...]: several runs; out/bench/NAME.json is the report of the fastest, with the
# milliseconds per step of each five steps of all of them. (The series, every fifth step, costs a fifth of a Lambda pass
# a step and 24 bytes per particle; the wall time leaves it out.)
run() {
  local name=$1 ranks=$2 scene=$3 steps=$4 k settings=()
  shift 4
  for k in "$@"; do settings+=(--set "$k"); done
  for ((k = 1; k <= repeats; k++)); do
    rm -rf "out/bench/$name-$k"
    mpirun -np "$ranks" build/bench/trevi "$scene" --steps "$steps" --output "out/bench/$name-$k" --progress none \
      --set output.series.every_steps=5 "${settings[@]}" >"out/bench/$name-$k.log" 2>&1 ||
      fail "$name failed; see out/bench/$name-$k.log"
  done
  python3 - "$name" "$repeats" <<'PYTHON'
import csv, json, sys
name, repeats = sys.argv[1], int(sys.argv[2])
folders = [f"out/bench/{name}-{k + 1}" for k in range(repeats)]
report = min((json.load(open(f"{folder}/run.json")) for folder in folders), key=lambda run: run["wall_seconds"])
report["step_ms"] = []
for folder in folders:
    wall = [float(row["wall_seconds"]) for row in csv.DictReader(open(f"{folder}/series.csv"))]
    # The first steps fill caches and grow the lists.
    report["step_ms"] += [1e3 * (b - a) / 5 for a, b in zip(wall[1:], wall[2:])]
json.dump(report, open(f"out/bench/{name}.json", "w"))
PYTHON
}

# table TITLE NAME ...: one column per run, the phases below.
table() {
  python3 - "$@" <<'PYTHON'
import json, statistics, sys
title, names = sys.argv[1], sys.argv[2:]
runs = [json.load(open(f"out/bench/{name}.json")) for name in names]
def row(label, values, form="{:.1f}"):
    print(f"{label:<36}" + "".join(f"{form.format(v) if v is not None else '-':>20}" for v in values))
print(f"\n{title}")
row("", names, "{}")
row("ns per particle and step", [1e9 / r["particle_steps_per_second"] for r in runs])
row("ms per step", [1e3 / r["steps_per_second"] for r in runs])
row("  median of five steps", [statistics.median(r["step_ms"]) for r in runs])
row("  fastest five steps", [min(r["step_ms"]) for r in runs])
row("simulated s per wall s", [r["simulated_seconds"] / r["wall_seconds"] for r in runs], "{:.2f}")
row("ns per pair and pass", [r["nanoseconds_per_pair"] for r in runs], "{:.2f}")
row("bytes per particle", [r["bytes_per_particle"] for r in runs], "{:.0f}")
order = list(dict.fromkeys(p["name"] for r in runs for p in r["phases"]))
for phase in order:
    seconds = [{p["name"]: p["seconds"]["mean"] for p in r["phases"]}.get(phase) for r in runs]
    row(f"  {phase}, ms a step", [s and 1e3 * s / r["steps"] for s, r in zip(seconds, runs)], "{:.2f}")
PYTHON
}

# ratio NAME1 NAME2: what two ranks gain, by the median and by the fastest five steps.
ratio() {
  python3 - "$@" <<'PYTHON'
import json, statistics, sys
one, two = (json.load(open(f"out/bench/{name}.json"))["step_ms"] for name in sys.argv[1:])
print(f"{sys.argv[2]} is {statistics.median(one) / statistics.median(two):.2f} times as fast as {sys.argv[1]} by the "
      f"median, {min(one) / min(two):.2f} times by the fastest five steps")
PYTHON
}

falling_cube() {
  local ranks
  # Writing is not counted, and kept rare.
  for ranks in 1 2; do
    run "cube_np$ranks" "$ranks" inputs/falling_cube.toml 100 'density.precision="single"' output.vtu.every=1000.0 \
      output.checkpoint.every=1000.0
  done
  table "Falling cube, 100 steps, single precision" cube_np1 cube_np2
}

# The loops of the default step, measured on a jittered lattice of about as many particles in the same minute.
limit() {
  local set
  for set in $(build/bench/tests/benchmarks/bench_pairs --instruction_sets=all --benchmark_list_tests |
    sed -n 's|^1e+05/search/single/\(.*\)@h/s=2/.*|\1|p'); do
    build/bench/tests/benchmarks/bench_pairs "--instruction_sets=$set" \
      --benchmark_filter='^1e\+05/(search|density_spiky|delta_spiky)/single/.*@h/s=2/' \
      "--benchmark_out=out/bench/parts-$set.json" --benchmark_out_format=json >/dev/null
    run "limit_$set" 1 inputs/bench_rest.toml 60 "run.instruction_set=\"$set\"" "$sloshing"
    python3 - "$set" <<'PYTHON'
import json, statistics, sys
name = sys.argv[1]
parts = {b["name"].split("/")[1]: b["ns_per_pair"] for b in json.load(open(f"out/bench/parts-{name}.json"))["benchmarks"]}
run = json.load(open(f"out/bench/limit_{name}.json"))
passes = 4  # density and delta, twice each; as many in each step, as nothing is left out
phase = {p["name"]: 1e3 * p["seconds"]["mean"] / run["steps"] for p in run["phases"]}
pairs = 1e6 * (phase["Lambda"] + phase["Delta"]) / run["nanoseconds_per_pair"] / passes
coarse = phase["CoarseGrid"]
ms = {part: 1e-6 * pairs * ns * (1 if part == "search" else passes / 2) for part, ns in parts.items()}
step, total = statistics.median(run["step_ms"]), sum(ms.values()) + coarse
limit = {"step": step, "parts": total, **ms, "coarse": coarse, "step over parts": step / total,
         "coarse percent": 100 * coarse / step}
json.dump({"limit": limit, "ns per pair": parts}, open(f"out/bench/parts_{name}.json", "w"))
print(f"\nLimit, {name}: step {step:.1f} ms, parts {total:.1f} ms (" +
      ", ".join(f"{part} {value:.1f}" for part, value in ms.items()) +
      f", coarse grid {coarse:.1f}), ratio {step / total:.2f}; coarse grid {100 * coarse / step:.1f} % of the step")
PYTHON
  done
}

real_time() {
  local scene=inputs/bench_rest.toml ranks
  for ranks in 1 2; do
    run "rest_np$ranks" "$ranks" $scene 60
    run "slosh_np$ranks" "$ranks" $scene 60 "$sloshing"
    run "filters_np$ranks" "$ranks" $scene 60 "$sloshing" vorticity.epsilon=0.002 viscosity.c=0.001
  done
  table "Real time: 96,000 particles at rest, sloshing, and that with vorticity and XSPH; dt = 1/30 s" rest_np1 \
    rest_np2 slosh_np1 slosh_np2 filters_np1 filters_np2
  ratio rest_np1 rest_np2
  ratio slosh_np1 slosh_np2
}

# What a ball in the air, far from all water, costs.
obstacle() {
  run ball_np1 1 inputs/bench_rest.toml 60 'obstacle=[{type="sphere", center=[3.0, 2.0, 5.5], radius=0.3}]'
  table "96,000 particles at rest, without and with a ball in the air" rest_np1 ball_np1
  ratio ball_np1 rest_np1
}

# What ten balls of 3 spacings radius at the surface cost, that move freely or stand.
bodies() {
  local balls="" k
  for ((k = 0; k < 10; k++)); do
    balls+="{type=\"sphere\", center=[$((6 + 12 * (k % 5)))e-1, $((10 + 20 * (k / 5)))e-1, 4.0], radius=0.3"
    balls+="BODY}, "
  done
  run bodies_np1 1 inputs/bench_rest.toml 60 "body=[${balls//BODY/, density=500.0}]"
  run stand_np1 1 inputs/bench_rest.toml 60 "obstacle=[${balls//BODY/}]"
  # Balls make waves, so that all rows are swept.
  table "96,000 particles, sloshing without solids, and with ten balls that float, and with ten that stand" slosh_np1 \
    bodies_np1 stand_np1
  ratio bodies_np1 slosh_np1
}

million() {
  local ranks
  for ranks in 1 2; do
    run "million_np$ranks" "$ranks" inputs/bench_rest.toml 15 'domain.max=[10.0, 10.0, 12.0]' \
      'particles.0.max=[10.0, 10.0, 10.0]'
  done
  table "1 million particles at rest" million_np1 million_np2
  ratio million_np1 million_np2
}

# record FILE: what table() and limit() print, as case, quantity, value; the processor in each row.
record() {
  python3 - "$1" "$(lscpu | sed -n 's/^Model name: *//p')" <<'PYTHON'
import csv, glob, json, statistics, sys
rows = []
for path in sorted(glob.glob("out/bench/*_np[12].json")):
    run = json.load(open(path))
    values = {"ms per step, median": statistics.median(run["step_ms"]), "ms per step, fastest": min(run["step_ms"]),
              "simulated s per wall s": run["simulated_seconds"] / run["wall_seconds"],
              "bytes per particle": run["bytes_per_particle"]}
    rows += [(path.split("/")[-1][:-5], quantity, value) for quantity, value in values.items()]
for path in sorted(glob.glob("out/bench/parts_*.json")):
    name = path.split("parts_")[1][:-5]
    for group, values in json.load(open(path)).items():
        rows += [(f"{group}, {name}", quantity, value) for quantity, value in values.items()]
with open(sys.argv[1], "w", newline="") as file:
    out = csv.writer(file, lineterminator="\n")
    out.writerow(["case", "quantity", "value", "processor"])
    out.writerows([case, quantity, f"{value:.4g}", sys.argv[2]] for case, quantity, value in rows)
PYTHON
}

# All frames of the falling cube. Differences grow after the impact in frame 50, whatever made them.
density_curve() {
  rm -rf "out/bench/curve_$1"
  mpirun -np 2 build/bench/trevi inputs/falling_cube.toml --output "out/bench/curve_$1" --progress none \
    --set output.vtu.every=1000.0 --set output.checkpoint.every=1000.0 --set "density.precision=\"$2\"" \
    --set "particles.0.velocity=[$3, 0.0, 0.0]" >"out/bench/curve_$1.log" 2>&1 ||
    fail "curve_$1 failed; see out/bench/curve_$1.log"
}

precision() {
  density_curve double double 0.0
  density_curve disturbed double 1e-12
  density_curve single single 0.0
  python3 - <<'PYTHON'
import csv
def curve(name):
    return [float(row["density_mean"]) for row in csv.DictReader(open(f"out/bench/curve_{name}/series.csv"))]
print("\nMean density of the falling cube against double precision")
for name, what in (("single", "single precision"), ("disturbed", "double, started at 1e-12 m/s")):
    off = [100 * abs(a / b - 1) for a, b in zip(curve(name), curve("double"))]
    print(f"{what:<30} mean {sum(off) / len(off):.3f} %, to frame 80 at most {max(off[:81]):.3f} %, "
          f"later {max(off[81:]):.3f} %")
PYTHON
}

output() {
  local ranks
  for ranks in 1 2; do
    printf '\nOutput, 1 million particles, %s rank(s)\n' "$ranks"
    mpirun -np "$ranks" build/bench/tests/benchmarks/bench_output out/bench/output
  done
  rm -rf out/bench/output
}

main() {
  local quick repeats csv
  parse_arguments "$@"
  cd "$trevi_root"
  trevi_packages+=(libbenchmark-dev)
  install_packages
  mpi_environment
  # Ranks that are bound to one core each would share it with whatever else runs there.
  export OMPI_MCA_hwloc_base_binding_policy=none
  # On a shared machine a rank that waits should not keep the other one from its core.
  export OMPI_MCA_mpi_yield_when_idle="${OMPI_MCA_mpi_yield_when_idle:-1}"
  # What is measured is a core; ranks are not bound, so each would take all cores for its threads.
  export OMP_NUM_THREADS="${OMP_NUM_THREADS:-1}"
  build_benchmarks
  rm -rf out/bench
  mkdir -p out/bench
  lscpu | grep -E '^(Model name|CPU\(s\)|CPU max MHz|L[123]d? cache)'
  [[ $quick == yes ]] || build/bench/tests/benchmarks/bench_pairs
  falling_cube
  limit
  real_time
  obstacle
  bodies
  if [[ $quick == no ]]; then
    million
    precision
  fi
  [[ -z $csv ]] || record "$csv"
  output
}

main "$@"
