# The suite of `pliant evaluate suite` as jobs of Snakemake: scenes x methods, every job a command of pliant.
#   snakemake --cores 2                                            what `pliant evaluate suite` runs
#   snakemake --cores 8 --cluster 'sbatch -c {threads}' --jobs 8   the same on a cluster
# Settings are in suite.json beside this file.  A job that was killed continues where its run directory stands.
# A method that fails on a scene keeps its row, as a failure; what else fails ends the job.  Scenes that are begun are
# finished first (priority).

import glob
import hashlib
import json
import os
import shutil
import subprocess
import time

configfile: "suite.json"

PLIANT = config["pliant"]
SCENES = config["scenes"]
METHODS = config["methods"]
THREADS = config["threads"]
OF_MOTION = ["unseen.relative_error:lower", "unseen.frequency_error:lower", "video.relative_error:lower",
             "log10_young_error"]
METRICS = {
    "motion": OF_MOTION,
    "jolt": OF_MOTION,
    "segmentation": ["miou", "boundary_miou"],
    "repair": ["psnr"],
}
TITLES = {"jolt": "Motion, from the video of a jolt"}

wildcard_constraints:
    scene="[^/]+/[^/]+",  # kind/seed: seeds of a kind are no independent scenes
    method="[^/]+",
    motion="motion|jolt",


def pliant(log, *words):
    """Runs a command of pliant; its output goes to the log."""
    with open(log, "a") as text:
        command = [PLIANT, *map(str, words), "--threads", str(THREADS), "--quiet"]
        text.write(" ".join(command) + "\n")
        text.flush()
        subprocess.run(command, check=True, stdout=text, stderr=subprocess.STDOUT)


class MethodFailed(Exception):
    """What a method that failed said last."""


def of_method(log, *words):
    """A command of the method itself, which has failed where pliant ends with 1 or 3."""
    try:
        pliant(log, *words)
    except subprocess.CalledProcessError as error:
        if error.returncode not in (1, 3):
            raise
        raise MethodFailed(open(log).read().strip().splitlines()[-1]) from error


def write_json(file, value):
    with open(file + ".partial", "w") as out:
        json.dump(value, out, indent=1)
    os.rename(file + ".partial", file)


def read_json(file):
    with open(file) as text:
        return json.load(text)


def earlier_seconds(run):
    """That earlier attempts took in a run directory; None where one was killed before it could write them down."""
    if not os.path.exists(run + ".seconds"):
        return None if os.path.exists(run) else 0
    seconds = read_json(run + ".seconds")
    os.remove(run + ".seconds")  # what is killed from here on is not measured
    return seconds


def score(task, scene, method, log, out, measure, run=None):
    """Writes what `measure` returns, and how long all attempts in the directory `run` took unless it says "seconds"
    itself (None = not measured).  What its commands `of_method` fail with is a result; all else ends the job."""
    result = {"task": task, "scene": scene, "method": method}
    earlier, begin = earlier_seconds(run) if run else 0, time.monotonic()
    try:
        result.update(measure())
    except MethodFailed as error:
        result["failed"] = str(error)
    finally:
        seconds = None if earlier is None else earlier + time.monotonic() - begin
        if run:
            os.makedirs(os.path.dirname(run), exist_ok=True)
            write_json(run + ".seconds", seconds)
    result.setdefault("seconds", seconds)
    write_json(out, result)


def copy_of(prepared, run):
    """A run directory to work in, unless an earlier attempt has left one."""
    if not os.path.exists(run):
        shutil.copytree(prepared, run + ".partial", dirs_exist_ok=True)
        os.rename(run + ".partial", run)


def has_moved(scene, run):
    """Whether the suite's folder has moved since a run directory was made, which knows the full path of its scene."""
    if not os.path.exists(f"{run}/run.json"):
        return False
    source = (read_json(f"{run}/run.json").get("scene") or {}).get("source", "")
    return os.path.realpath(os.path.join(run, source)) != os.path.realpath(f"scenes/{scene}")


def attach(log, scene, run):
    """Tells a run directory with a finished segmentation where its scene has moved to; its stages stay."""
    if has_moved(scene, run):
        pliant(log, "segment", f"scenes/{scene}", "--out", run)


def drop_moved(scene, run):
    """Without a finished segmentation a scene elsewhere is another one: what is unfinished begins anew."""
    if has_moved(scene, run):
        shutil.rmtree(run)


def digest(*settings):
    """Of what a job depends on besides its input; a job whose digest has changed runs again."""
    return hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()[:12]


def of_scene(wildcards):
    return digest(SCENES[wildcards.scene], config["demo"], config.get("version"))


def of_prepared(wildcards):
    return digest(of_scene(wildcards), config["particles"])


def prepared_run(wildcards):
    return f"prepared/{wildcards.scene}-{of_prepared(wildcards)}"


def of_motion(wildcards):
    return digest(of_prepared(wildcards), config["simulate"], METHODS[wildcards.motion][wildcards.method])


def scenes_of(task):
    """Some kinds lack what a task needs: the potted flower has one video alone."""
    return [scene for scene in SCENES if SCENES[scene]["kind"] not in config.get("lacking", {}).get(task, [])]


def of_segmentation(wildcards):
    return digest(of_scene(wildcards), METHODS["segmentation"][wildcards.method])


def mean(values):
    """Of what is known."""
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None


def only(pattern):
    (file,) = glob.glob(pattern)
    return file


def has(score, metric):
    """Whether a score has a metric such as "unseen.relative_error:lower": the potted flower has no unseen motion."""
    for key in metric.split(":")[0].split("."):
        score = score.get(key) if isinstance(score, dict) else None
    return score is not None


rule all:
    input:
        "RESULTS.md",


rule scene:
    output:
        "scenes/{scene}/scene.json",
    log:
        "logs/{scene}/scene.log",
    params:
        settings=of_scene,
    threads: THREADS
    run:
        chosen = SCENES[wildcards.scene]
        pliant(log[0], "demo", "--kind", chosen["kind"], "--seed", chosen["seed"], *config["demo"],
               "--out", f"scenes/{wildcards.scene}", "--overwrite")


# What all motion methods begin with: the object cut out by the true masks, the hole closed, driving particles.
rule prepared:
    input:
        "scenes/{scene}/scene.json",
    output:
        touch("prepared/{scene}.done"),
    log:
        "logs/{scene}/prepared.log",
    params:
        settings=of_prepared,
    priority: 1
    threads: THREADS
    run:
        run = prepared_run(wildcards)
        drop_moved(wildcards.scene, run)
        pliant(log[0], "segment", f"scenes/{wildcards.scene}", "--out", run)
        for stage in ("extract", "repair"):
            pliant(log[0], stage, run)
        pliant(log[0], "seed", run, "--particles", config["particles"])


# E from a video or from a prediction; then forces that the video does not show, against the truth.  The video is the
# scene's, of a poke, or that of a jolt: an impulse at a known time, from which on a body at rest swings freely.
rule motion:
    input:
        "prepared/{scene}.done",
    output:
        "scores/{motion}/{method}/{scene}.json",
    log:
        "logs/{scene}/{motion}-{method}.log",
    params:
        settings=of_motion,
    priority: 2
    threads: THREADS
    run:
        scene, task, method = wildcards.scene, wildcards.motion, METHODS[wildcards.motion][wildcards.method]
        truth = f"scenes/{scene}/truth"
        run = f"runs/{scene}/{task}-{wildcards.method}-{params.settings}"
        os.makedirs(f"runs/{scene}", exist_ok=True)

        def measure():
            copy_of(prepared_run(wildcards), run)
            attach(log[0], scene, run)
            errors = {"video": {}, "unseen": {}}
            video = read_json(f"scenes/{scene}/scene.json")["video"]
            shown, of_video = os.path.splitext(os.path.basename(video["file"]))[0], []
            if task == "jolt":
                (impulse,) = [row for row in read_json(f"{truth}/jolt/interactions.json") if row["type"] == "impulse"]
                shown, of_video = "jolt", ["--video", f"scenes/{scene}/videos/jolt.mp4", "--video-camera",
                                           video["camera"], "--start", impulse["start"]]
            for command in method["commands"]:
                of_method(log[0], command[0], run, *command[1:], *(of_video if command[0] == "fit" else []))
            # A motion to a folder; the potted flower has one alone, that of its video.
            folders = [os.path.dirname(file) for file in sorted(glob.glob(f"{truth}/*/trajectory.h5"))]
            motions = {os.path.basename(folder): folder for folder in folders} or {shown: truth}
            for name, folder in motions.items():
                of_method(log[0], "simulate", run, "--interactions", f"{folder}/interactions.json",
                          *config["simulate"], *method["simulate"])
                pliant(log[0], "evaluate", "trajectory", only(f"{run}/objects/*/trajectory.h5"),
                       f"{folder}/trajectory.h5", "--out", f"{run}/{name}.json")
                found = read_json(f"{run}/{name}.json")
                for key in ("relative_error", "frequency_error"):
                    errors["video" if name == shown else "unseen"].setdefault(key, []).append(found[key])
            pliant(log[0], "evaluate", "material", only(f"{run}/objects/*"), truth, "--out", f"{run}/young.json")
            metrics = {kind: {key: mean(values) for key, values in by.items()} for kind, by in errors.items()}
            metrics["log10_young_error"] = read_json(f"{run}/young.json")["log10_young_error"]
            return metrics

        score(task, scene, wildcards.method, log[0], output[0], measure, run)


# Labels from the masks of seven in eight photos, against the masks of the eighth.
rule segmentation:
    input:
        "scenes/{scene}/scene.json",
    output:
        "scores/segmentation/{method}/{scene}.json",
    log:
        "logs/{scene}/segmentation-{method}.log",
    params:
        settings=of_segmentation,
    priority: 2
    threads: THREADS
    run:
        scene = wildcards.scene
        run = f"runs/{scene}/segmentation-{wildcards.method}-{params.settings}"

        def measure():
            drop_moved(scene, run)
            of_method(log[0], "segment", f"scenes/{scene}", "--out", run, "--hold-out",
                      *METHODS["segmentation"][wildcards.method]["segment"])
            pliant(log[0], "evaluate", "segmentation", f"{run}/held_out", f"scenes/{scene}/masks", "--common",
                   "--match", "overlap", "--out", f"{run}/segmentation.json")
            found = read_json(f"{run}/segmentation.json")
            return {"miou": found["miou"], "boundary_miou": found["boundary_miou"]}

        score("segmentation", scene, wildcards.method, log[0], output[0], measure, run)


# The hole behind the object, over pixels that no photo shows; OpenCV fills every view by itself.
rule repair:
    input:
        "prepared/{scene}.done",
    output:
        ours="scores/repair/ours/{scene}.json",
        opencv="scores/repair/opencv/{scene}.json",
    log:
        "logs/{scene}/repair.log",
    params:
        settings=of_prepared,
    priority: 2
    threads: THREADS
    run:
        scene, found = wildcards.scene, f"logs/{wildcards.scene}/repair-{params.settings}.json"
        prepared = prepared_run(wildcards)

        def measure(key, seconds):
            if not os.path.exists(found):
                pliant(log[0], "evaluate", "repair", prepared, f"scenes/{scene}", "--out", found)
            return {"psnr": read_json(found)[key], "seconds": seconds}

        # The repair was made with the prepared run; the time of OpenCV's is part of the evaluation's.
        ours = read_json(f"{prepared}/run.json")["stages"]["repair"]["wall_s"]
        score("repair", scene, "ours", log[0], output.ours, lambda: measure("psnr", ours))
        score("repair", scene, "opencv", log[0], output.opencv, lambda: measure("psnr_opencv", None))


# Failures and times of each method; ours against each other one, with intervals over scenes.
rule results:
    input:
        [
            f"scores/{task}/{method}/{scene}.json"
            for task in METHODS
            for scene in scenes_of(task)
            for method in METHODS[task]
        ],
    output:
        "RESULTS.md",
    params:
        settings=digest(config),
    log:
        "logs/results.log",
    run:
        version = subprocess.run([PLIANT, "--version"], capture_output=True, text=True).stdout.strip()
        processor = [line.split(": ")[1] for line in open("/proc/cpuinfo") if line.startswith("model name")][:1]
        text = f"# Results of the suite\n\nPliant {version}, {''.join(processor).strip()}, one thread a job.  "
        text += f"{len(SCENES)} scenes: `pliant demo {' '.join(map(str, config['demo']))}` of the kinds "
        text += f"{', '.join(sorted({scene.split('/')[0] for scene in SCENES}))}.\n"
        for task, methods in METHODS.items():
            # Of these settings alone: there may be scores of earlier ones.
            shutil.rmtree(f"tables/{task}", ignore_errors=True)
            compared, scores, scenes = f"tables/{task}/of", {}, scenes_of(task)
            for method in methods:
                scores[method] = [read_json(f"scores/{task}/{method}/{scene}.json") for scene in scenes]
                for scene in scenes:
                    copy = f"{compared}/{method}/{scene}.json"
                    os.makedirs(os.path.dirname(copy), exist_ok=True)
                    shutil.copyfile(f"scores/{task}/{method}/{scene}.json", copy)
            folders = [f"{method}={compared}/{method}" for method in sorted(methods, key=lambda m: m != "ours")]
            known = [score for own in scores.values() for score in own]
            shown = [metric for metric in METRICS[task] if any(has(score, metric) for score in known)]
            metrics = [word for metric in shown for word in ("--metric", metric)]
            text += f"\n## {TITLES.get(task, task.capitalize())}\n\n"
            text += "| method | what it does | failed | mean time [s] |\n|---|---|---|---|\n"
            for method, own in scores.items():
                seconds = mean([score["seconds"] for score in own])
                failed = sum("failed" in score for score in own)
                text += f"| {method} | {methods[method].get('what', '')} | {failed} of {len(own)} | "
                text += "–" if seconds is None else f"{seconds:.0f}"
                text += " |\n"
            if len(methods) < 2:
                text += f"\nThere is no second method to compare with; the scores are in `scores/{task}`.\n"
            elif not shown:
                text += f"\nNo method has a result to compare; `scores/{task}` says how each failed.\n"
            else:
                pliant(log[0], "evaluate", "compare", *folders, *metrics, "--out", f"tables/{task}")
                text += "\n" + open(f"tables/{task}/compare.md").read()
        with open(output[0] + ".partial", "w") as out:
            out.write(text)
        os.rename(output[0] + ".partial", output[0])
