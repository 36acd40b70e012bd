import pytest

from mimeline.reporting.style import _luminance, colours, readable_on, themes


def contrast(a: str, b: str) -> float:
    high, low = sorted((_luminance(a), _luminance(b)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("name", list(colours()))
def test_the_text_on_an_action_can_be_read_in_both_themes(name):
    assert all(contrast(c, readable_on(c)) >= 4.5 for c in colours()[name])


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_ink_and_soft_text_can_be_read_on_the_page(theme):
    values = themes()[theme]
    assert contrast(values["--ink"], values["--paper"]) >= 7
    assert contrast(values["--soft"], values["--paper"]) >= 4.5
    assert contrast(values["--soft"], values["--raised"]) >= 4.5


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_no_two_actions_share_a_colour(theme):
    shown = [pair[theme == "dark"] for pair in colours().values()]
    assert len(set(shown)) == len(shown)
