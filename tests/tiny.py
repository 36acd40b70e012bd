"""The smallest model that has every part: of a timeline generator, for tests that train one."""

ARCHITECTURE = {
    "width": 16,
    "heads": 2,
    "base_layers": 1,
    "branch_layers": 1,
    "branches": "halves",
    "timeline_tokens": "initial",
    "schedule": "cosine",
    "diffusion_steps": 100,
}
