"""Train RLlib's PPO for one iteration; prints a message if `ray[rllib]` is not installed.

python examples/train_rllib.py
"""

import gymnasium

import trundle  # noqa: F401 (registers the environments)

LEVEL = "trundle/PushAroundEasy-v1"


def main() -> None:
    """Train for one iteration of 1000 steps."""
    try:
        from ray.rllib.algorithms.ppo import PPOConfig
        from ray.tune.registry import register_env
    except ImportError as error:
        print(f"skipped: {error}; pip install 'ray[rllib]' torch")
        return
    register_env("push", lambda options: gymnasium.make(LEVEL, dtype="float32", **options))
    config = (
        PPOConfig()
        .environment("push")
        .env_runners(num_env_runners=0, num_envs_per_env_runner=4)
        .training(train_batch_size_per_learner=1000, minibatch_size=250, num_epochs=2)
    )
    result = config.build_algo().train()
    print(f"return after one iteration: {result['env_runners'].get('episode_return_mean')}")


if __name__ == "__main__":
    main()
