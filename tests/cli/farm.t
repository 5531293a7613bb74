#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The examples for farms: an array job on a Slurm cluster of this one machine,
# started here for the test, and the Open Job Description template.
. "$(dirname "$0")/lib.sh"
need_python
export GLAREPP="$glarepp"

mkdir in local
for n in 01 02 03 04 05 06 07 08 09 10 11 12; do
    frame in/shot.00$n.exr size=48x32 seed=$n
done
"$glarepp" -q --engine fft --hdr local/lit.####.exr 'in/shot.####.exr' || exit 1

# as_local FOLDER DESCRIPTION: all frames, whole, nothing else
as_local()
{
    is "$(ls -A "$1" | xargs)" "$(ls local | xargs)" "$2: all frames, nothing else"
    differ=
    for lit in local/*; do
        cmp -s "$lit" "$1/${lit#local/}" || differ="$differ $lit"
    done
    is "$differ" '' "$2: the bytes of a local run"
}

# -- the script by itself -------------------------------------------------------

mkdir alone
for task in 0 1 2 3; do # the last has nothing to do
    SLURM_ARRAY_TASK_ID=$task sh "$root/examples/slurm.sh" 1 12 5 \
        'in/shot.####.exr' 'alone/lit.####.exr' --engine fft || echo "task $task"
done >out 2>&1
is "$(cat out)" '' 'slurm.sh: quiet success of each range'
as_local alone 'slurm.sh'
env -u SLURM_ARRAY_TASK_ID sh "$root/examples/slurm.sh" 1 12 5 \
    'in/shot.####.exr' 'none/lit.####.exr' >out 2>err
is "$? $(wc -l <err)" '2 1' 'slurm.sh without --array: an error, one line'
like "$(cat err)" 'slurm.sh: *--array*' 'slurm.sh without --array: says what to do'
no 'slurm.sh without --array: makes nothing' test -e none
SLURM_ARRAY_TASK_ID=1 sh "$root/examples/slurm.sh" 1 12 >out 2>err
like "$? $(cat err)" '2 slurm.sh: 2 arguments; *' 'slurm.sh with too few words'

# -- the camera of a scene --------------------------------------------------------

# A bpy of one scene, whose camera and sun are those that Blender wrote beside
# tests/frames/foliage.####.exr: what the script makes of it is that file again.
if "$python" -c 'import numpy' 2>/dev/null; then
    mkdir fake
    cat >fake/bpy.py <<'E_PY'
import json, os
from types import SimpleNamespace as S
import numpy

class Matrix:
    def __init__(self, m): self.m = numpy.array(m, dtype=float)
    def __getitem__(self, i): return self.m[i]
    def __matmul__(self, o): return Matrix(self.m @ o.m)
    def inverted(self): return Matrix(numpy.linalg.inv(self.m))
    def normalized(self):  # as mathutils: columns of length 1
        m = self.m.copy()
        m[:3, :3] /= numpy.linalg.norm(m[:3, :3], axis=0)
        return Matrix(m)

truth = json.load(open(os.environ["TRUTH"]))
frames = {f["frame"]: f for f in truth["frames"]}
graph = object()
camera = S(); sun = S(type="LIGHT", data=S(type="SUN", angle=0.009))

def calc(depsgraph, x, y, scale_x, scale_y):
    assert depsgraph is graph and x * 9 == y * 16 and scale_x == scale_y == 1.0
    return camera.lens
camera.calc_matrix_camera = calc

def frame_set(n):
    view = numpy.array(frames[n]["worldToCamera_rowmajor"]).reshape(4, 4).T.copy()
    view[2] *= -1  # Blender looks along -z
    world = numpy.linalg.inv(view)
    ndc = numpy.array(frames[n]["worldToNDC_blender_colvec"]).reshape(4, 4)
    camera.lens = Matrix(ndc @ world)
    world[:3, :3] *= 2.5  # a camera's scale does not count
    camera.matrix_world = Matrix(world)
    turn = numpy.eye(4); turn[:3, 2] = frames[n]["sun_dir_world"]
    sun.matrix_world = Matrix(turn)

scene = S(camera=camera, objects=[S(type="MESH", data=S()), sun], frame_set=frame_set,
          frame_start=1001, frame_end=1008, frame_step=1,
          render=S(resolution_x=truth["width"] * 2, resolution_y=truth["height"] * 2,
                   resolution_percentage=50, pixel_aspect_x=1.0, pixel_aspect_y=1.0))
context = S(scene=scene, evaluated_depsgraph_get=lambda: graph)
E_PY
    export TRUTH="$root/tests/frames/foliage.camera.json"
    ok 'blender_camera.py runs' env PYTHONPATH=fake "$python" \
        "$root/examples/blender_camera.py" -b shot.blend -- made.json
    "$python" - "$TRUTH" made.json >out 2>&1 <<'E_PY'
import json, math, sys
a, b = (json.load(open(p)) for p in sys.argv[1:])
assert (a["width"], a["height"]) == (b["width"], b["height"])
assert [f["frame"] for f in a["frames"]] == [f["frame"] for f in b["frames"]]
for f, g in zip(a["frames"], b["frames"]):
    for key in ("worldToCamera_rowmajor", "worldToNDC_blender_colvec",
                "sun_dir_world"):
        assert all(math.isclose(x, y, rel_tol=1e-5, abs_tol=1e-5)
                   for x, y in zip(f[key], g[key])), key
    assert abs(g["sun_radius_px"] / f["sun_radius_px"] - 1) < 0.05, g["sun_radius_px"]
E_PY
    is "$(cat out)" '' 'blender_camera.py: the matrices and the sun that Blender gave'
    for camera in made.json "$TRUTH"; do
        run -e fft --camera "$camera" --report - "$root/tests/frames/foliage.1004.exr"
        sed 's/.*"lights":\[{[^}]*"x":\([0-9.]*\),"y":\([0-9.]*\).*/\1 \2/' out
    done >places
    is "$(awk '{ printf "%d,%d ", $1, $2 }' places)" '283,129 283,129 ' \
        'blender_camera.py: --camera puts the sun where it was'
else
    skip 3 'no numpy'
fi

# -- the template ---------------------------------------------------------------

# Checks what the specification asks of the keys that are used, then runs the
# tasks as a worker would; prints verdicts.
cat >openjd.py <<'E_PY'
import re, subprocess, sys
import yaml
t = yaml.safe_load(open(sys.argv[1]))


def say(fine, text):
    print("ok" if fine else "not ok", "openjd.yaml: " + text)


def keys(o, needed, allowed):
    return set(needed) <= set(o) <= set(needed) | set(allowed)


NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,63}$")
say(t["specificationVersion"] == "jobtemplate-2023-09", "version")
say(keys(t, ["specificationVersion", "name", "steps"],
         ["description", "parameterDefinitions", "jobEnvironments", "$schema"])
    and len(t["name"]) <= 128, "keys of the template")
params = t["parameterDefinitions"]
kinds = {"INT": {"default": int, "minValue": int, "maxValue": int},
         "STRING": {"default": str},
         "PATH": {"default": str, "objectType": str, "dataFlow": str}}
say(all(NAME.match(p["name"]) and
        keys(p, ["name", "type"], ["description", *kinds[p["type"]]]) and
        all(isinstance(p[k], k_type) for k, k_type in kinds[p["type"]].items()
            if k in p) and
        p.get("objectType", "FILE") in ("FILE", "DIRECTORY") and
        p.get("dataFlow", "NONE") in ("NONE", "IN", "OUT", "INOUT")
        for p in params), "parameters")
say(len({p["name"] for p in params}) == len(params) <= 50, "no parameter twice")
(step,) = t["steps"]
say(keys(step, ["name", "script"], ["description", "parameterSpace",
         "stepEnvironments", "hostRequirements", "dependencies"]), "keys of the step")
say(all(keys(a, ["name"], ["min", "max"]) and
        a["name"].startswith(("amount.worker.", "amount."))
        for a in step["hostRequirements"]["amounts"]), "host requirements")
script = step["script"]
say(keys(script, ["actions"], ["embeddedFiles"]) and
    keys(script["actions"], ["onRun"], []) and
    keys(script["actions"]["onRun"], ["command"],
         ["args", "timeout", "cancelation"]), "keys of the script")
files = {f["name"]: f for f in script["embeddedFiles"]}
say(all(keys(f, ["name", "type", "data"], ["filename", "runnable"]) and
        f["type"] == "TEXT" and NAME.match(n) for n, f in files.items()), "files")
space = step["parameterSpace"]["taskParameterDefinitions"]
say(all(keys(s, ["name", "type", "range"], []) and s["type"] == "INT"
        for s in space) and len(space) == 1, "parameter space")

known = {"Param." + p["name"]: str(p.get("default", "")) for p in params}
known.update({"Param.InputFolder": "in", "Param.OutputFolder": "open",
              "Param.FirstFrame": "1", "Param.LastFrame": "12",
              "Param.FramesPerTask": "5", "Param.Options": "--engine fft"})
unknown = set()


def fill(text, more):
    def one(m):
        name = m.group(1).strip()
        if name not in known and name not in more:
            unknown.add(name)
        return more.get(name, known.get(name, ""))
    return re.sub(r"\{\{(.*?)\}\}", one, text)


m = re.match(r"(\d+)-(\d+):(\d+)$", fill(space[0]["range"], {}))
first, last, by = map(int, m.groups())
failed = []
for start in range(first, last + 1, by):
    more = {"Task.Param." + space[0]["name"]: str(start)}
    for name, f in files.items():
        open(name, "w").write(fill(f["data"], more))
        more["Task.File." + name] = name
    run = script["actions"]["onRun"]
    words = [fill(w, more) for w in [run["command"], *run["args"]]]
    p = subprocess.run(words, capture_output=True, text=True)
    lines = p.stderr.splitlines()
    done = [float(l.split()[1]) for l in lines if l.startswith("openjd_progress: ")]
    if (p.returncode or p.stdout or done != sorted(done) or
            done[:1] + done[-1:] != [0, 100] or
            not all(re.match("openjd_(progress|status): .", l) for l in lines)):
        failed.append((start, p.stderr))
say(not unknown, "no unknown name in braces " + ", ".join(sorted(unknown)))
say(not failed, "its tasks run " + str(failed or ""))
E_PY
if "$python" -c 'import yaml' 2>/dev/null; then
    "$python" openjd.py "$root/examples/openjd.yaml" >verdict 2>&1 ||
        echo 'not ok openjd.yaml: is checked to its end' >>verdict
    verdicts verdict
    as_local open 'openjd.yaml'
else
    skip 13 'no python3-yaml to read the template'
fi

# -- a cluster ------------------------------------------------------------------

daemons=
up=
end_daemons()
{
    if [ -n "$up" ]; then
        timeout 5 scancel --user="$(id -un)"
        wait_for 5 none_runs
    fi
    for pid in $daemons; do
        kill "$pid" 2>/dev/null
    done
    for pid in $daemons; do
        wait_for 3 no_process "$pid" || kill -9 "$pid" 2>/dev/null
    done
    daemons=
}
trap 'end_daemons 2>/dev/null; cleanup' EXIT

none_runs()
{
    [ -z "$(timeout 2 squeue -h)" ]
}

no_process()
{
    ! kill -0 "$1" 2>/dev/null
}

# wait_for SECONDS COMMAND...: until it succeeds
wait_for()
{
    ticks=$(($1 * 10))
    shift
    while ! "$@" 2>/dev/null; do
        ticks=$((ticks - 1))
        [ $ticks -gt 0 ] || return 1
        sleep 0.1
    done
}

# no_cluster WHY: the tests below cannot run here
no_cluster()
{
    skip 8 "$1"
    done_testing
    exit 0
}

PATH=$PATH:/usr/sbin:/sbin
for program in munged slurmctld slurmd sbatch scancel scontrol squeue sinfo; do
    command -v $program >/dev/null || no_cluster "no $program (slurm-wlm, munge)"
done

mkdir slurm slurm/state slurm/spool
host=$(hostname -s) user=$(id -un) base=$tmp/slurm
ports=$("$python" -c 'import socket
s = [socket.socket() for _ in range(2)]
for one in s:
    one.bind(("127.0.0.1", 0))
print(*(one.getsockname()[1] for one in s))')
cat >slurm/slurm.conf <<E_CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
CryptoType=crypto/munge
# (a requeued task waits for as long: the least that is taken)
AuthInfo=socket=$base/munge.socket,cred_expire=5
SlurmctldPort=${ports% *}
SlurmdPort=${ports#* }
StateSaveLocation=$base/state
SlurmdSpoolDir=$base/spool
SlurmctldPidFile=$base/slurmctld.pid
SlurmdPidFile=$base/slurmd.pid
# no cgroups, which containers often lack
ProctrackType=proctrack/pgid
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,sched_min_interval=100000
SlurmdParameters=config_overrides
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=farm Nodes=ALL Default=YES State=UP MaxTime=5
E_CONF
export SLURM_CONF="$base/slurm.conf"
unset SLURM_ARRAY_TASK_ID SLURM_JOB_ID SBATCH_PARTITION SBATCH_ACCOUNT

# start NAME COMMAND...: in the background, ended at exit
start()
{
    log=$base/$1.out
    shift
    "$@" </dev/null >"$log" 2>&1 &
    daemons="$! $daemons"
}

# why NAME: its last words
why()
{
    no_cluster "$1 does not run here: $(tail -n 1 "$base/$1.out" | tr '#' ' ')"
}

idle()
{
    sinfo -h -o %T | grep -qx idle
}

head -c 1024 /dev/urandom >slurm/key
chmod 600 slurm/key
# (forced: the folder is closed to other users)
start munged munged -F --force --num-threads=2 --key-file="$base/key" \
    --socket="$base/munge.socket" --pid-file="$base/munged.pid" \
    --log-file="$base/munged.log" --seed-file="$base/seed"
wait_for 5 test -S "$base/munge.socket" || why munged
munge -S "$base/munge.socket" -n -o /dev/null 2>/dev/null || why munged
start slurmctld slurmctld -D -i
start slurmd slurmd -D -N "$host"
wait_for 10 idle || why slurmd
up=yes

# -- the array, and a task that is killed ---------------------------------------

# The second task, frames 5 to 8, waits at frame 7: nobody writes into the pipe.
mkdir lit
mv in/shot.0007.exr kept.exr
mkfifo in/shot.0007.exr
job=$(sbatch --parsable --array=0-2 --output=log.%a "$root/examples/slurm.sh" \
    1 12 4 "$tmp/in/shot.####.exr" "$tmp/lit/lit.####.exr" --engine fft 2>&1)
like "$job" '[0-9]*' 'slurm: the array is taken'
others_made()
{
    [ -e lit/lit.0006.exr ] && [ -e lit/lit.0004.exr ] && [ -e lit/lit.0012.exr ]
}
ok 'slurm: the other tasks are made' wait_for 12 others_made
before=$(stat -c '%i %y' lit/lit.0005.exr lit/lit.0006.exr)
scancel --full --signal=KILL "${job}_1"
killed()
{
    ! squeue -h -j "${job}_1" -t running,completing -o %T | grep -q .
}
ok 'slurm: a task is killed midway' wait_for 5 killed
is "$(ls -A lit | xargs)" "$(ls local | grep -v '000[78]' | xargs)" \
    'slurm: what it leaves is whole frames alone'

rm in/shot.0007.exr
mv kept.exr in/shot.0007.exr
ok 'slurm: it is queued again' scontrol requeue "${job}_1"
resumed()
{
    [ -e lit/lit.0008.exr ] && none_runs
}
wait_for 20 resumed || { note "$(squeue)"; note "$(cat log.1)"; }
as_local lit 'slurm'
is "$(stat -c '%i %y' lit/lit.0005.exr lit/lit.0006.exr)" "$before" \
    'slurm: frames that were there are not made again'

done_testing
