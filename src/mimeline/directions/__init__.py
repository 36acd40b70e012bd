"""Timelines from what people say: simple sentences, or any text through a language model."""
