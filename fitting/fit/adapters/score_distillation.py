#!/usr/bin/env python3
"""Score distillation by a text-to-video model, for `pliant fit --guidance-cmd "python3 score_distillation.py --prompt 'a flower swings'"`.

NEVER RUN WITH THE OFFICIAL WEIGHTS: only against a stand-in of the same interface.

Protocol (fitting/observe/guidance.h): the last argument is a folder; requests are lines of JSON on standard input, frames.f32 is read
and gradient.f32 written there.  Needs the Python packages numpy, torch, diffusers, transformers and accelerate, and a GPU with about
16 GB.  Written for diffusers 0.27: any pipeline with vae, unet (latents [B, C, T, h, w]), a scheduler with alphas_cumprod, and
encode_prompt, such as TextToVideoSDPipeline.

The gradient is that of Poole et al., "DreamFusion" (2022), eq. 3: noise eps is added to the latents z of the frames at a random
time t, z_t = sqrt(a) z + sqrt(1 - a) eps with a = alphas_cumprod[t], and w(t) (eps_hat(z_t) - eps), with w = 1 - a and the model's
guided eps_hat, goes back through the encoder alone, not through the model.  It is divided by the number of latents.
"""

import argparse
import json
import pathlib
import sys

STEP = 64  # sizes of the frames are multiples of this: 8 pixels a latent, 8 latents at the model's coarsest level


def model_size(width, height, area):
    """The size nearest to the model's area with nearly the picture's shape."""
    scale = (area / (width * height)) ** 0.5
    return tuple(max(STEP, round(side * scale / STEP) * STEP) for side in (width, height))


def predicted_noise(output, noisy, a, kind):
    """eps_hat from what a model of this kind gives for z_t."""
    if kind == "epsilon":
        return output
    if kind == "v_prediction":  # v = sqrt(a) eps - sqrt(1 - a) z
        return a**0.5 * output + (1 - a) ** 0.5 * noisy
    raise ValueError(f"the scheduler's prediction_type is {kind}, known are epsilon and v_prediction")


class Guide:
    def __init__(self, pipeline, options):
        import torch

        self.torch, self.pipeline, self.options = torch, pipeline, options
        self.device, self.dtype = options.device, next(pipeline.unet.parameters()).dtype
        for network in (pipeline.vae, pipeline.unet):
            network.requires_grad_(False)
        with torch.no_grad():
            told, untold = pipeline.encode_prompt(options.prompt, self.device, 1, True, options.negative_prompt)
        self.prompts = torch.cat([untold, told])

    def latents(self, frames):
        """[T, 3, H, W] in [0, 1] -> [T, C, h, w]."""
        size = model_size(frames.shape[3], frames.shape[2], self.options.area)[::-1]
        scaled = self.torch.nn.functional.interpolate(frames, size=size, mode="bilinear", align_corners=False, antialias=True)
        vae = self.pipeline.vae
        return vae.encode((2 * scaled - 1).to(self.dtype)).latent_dist.mode() * vae.config.scaling_factor

    def noise_error(self, z, step):
        """eps_hat - eps for latents [1, C, T, h, w] and the share a of them in z_t; the same for the same step."""
        torch, scheduler = self.torch, self.pipeline.scheduler
        random = torch.Generator().manual_seed(1000003 * self.options.seed + step)
        last = scheduler.config.num_train_timesteps - 1
        low, high = (round(share * last) for share in self.options.noise)
        t = int(torch.randint(low, high + 1, (1,), generator=random))
        a = float(scheduler.alphas_cumprod[t])
        noise = torch.randn(z.shape, generator=random).to(self.device, self.dtype)
        noisy = a**0.5 * z + (1 - a) ** 0.5 * noise
        output = self.pipeline.unet(torch.cat([noisy, noisy]), torch.tensor(t, device=self.device), encoder_hidden_states=self.prompts).sample
        untold, told = predicted_noise(output, noisy, a, scheduler.config.prediction_type).chunk(2)
        return (untold + self.options.guidance_scale * (told - untold) - noise).float(), a

    def step(self, frames, number):
        """Loss and gradient [T, H, W, 3] of frames [T, H, W, 3].  The loss, half the weighted mean square of eps_hat - eps, is only to look at."""
        torch = self.torch
        pictures = torch.from_numpy(frames).permute(0, 3, 1, 2).float().to(self.device)
        chunks = range(0, len(pictures), self.options.encode_chunk)
        with torch.no_grad():
            z = torch.cat([self.latents(pictures[k : k + self.options.encode_chunk]) for k in chunks])
            error, a = self.noise_error(z.transpose(0, 1)[None], number)
        error = error[0].transpose(0, 1)
        # A few frames at a time: the encoder's memory grows with them.  Half precision would lose what is divided before.
        gradient = torch.zeros_like(pictures)
        for k in chunks:
            some = pictures[k : k + self.options.encode_chunk].clone().requires_grad_(True)
            self.latents(some).backward(((1 - a) * error[k : k + self.options.encode_chunk]).to(self.dtype))
            gradient[k : k + self.options.encode_chunk] = some.grad / error.numel()
        return 0.5 * (1 - a) * float(error.square().mean()), gradient.permute(0, 2, 3, 1).contiguous().cpu().numpy()


def load_guide(options):
    import torch
    from diffusers import DiffusionPipeline

    options.device = "cuda" if torch.cuda.is_available() else "cpu"
    half = options.device == "cuda"
    pipeline = DiffusionPipeline.from_pretrained(options.model, torch_dtype=torch.float16 if half else torch.float32, variant="fp16" if half else None)
    return Guide(pipeline.to(options.device), options)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--model", default="damo-vilab/text-to-video-ms-1.7b")
    parser.add_argument("--prompt", required=True, help="what the motion should look like")
    parser.add_argument("--negative-prompt", default="")
    parser.add_argument("--guidance-scale", type=float, default=100, help="of the prompt against the negative one; DreamFusion: 100")
    parser.add_argument("--noise", type=float, nargs=2, default=(0.02, 0.98), metavar=("LOW", "HIGH"), help="range of t, as shares of the model's times")
    parser.add_argument("--area", type=int, default=256 * 256, help="pixels of a frame that the model was trained on")
    parser.add_argument("--encode-chunk", type=int, default=2, help="frames that are encoded at once")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()

    import numpy

    guide = load_guide(options)
    print(json.dumps({"ready": 1, "name": f"score distillation by {options.model}"}), flush=True)
    for line in sys.stdin:
        request = json.loads(line)
        if "quit" in request:
            break
        try:
            frames = numpy.fromfile(options.folder / request["frames"], "<f4").reshape(request["shape"])
            loss, gradient = guide.step(frames, request["step"])
            gradient.astype("<f4").tofile(options.folder / request["gradient"])
            answer = {"step": request["step"], "loss": loss}
        except (RuntimeError, ValueError) as problem:  # such as too little memory
            answer = {"step": request["step"], "error": str(problem)}
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
