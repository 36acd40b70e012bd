import pytest

from mimeline.media.plain_words import in_plain_words


@pytest.mark.parametrize(
    ("raw", "plain"),
    [
        ("<urlopen error [Errno 111] Connection refused>", "refused the connection"),
        ("<urlopen error [Errno -2] Name or service not known>", "no such host"),
        ("[Errno -3] Temporary failure in name resolution", "cannot be looked up now"),
        ("HTTPSConnectionPool(host='x', port=443): Read timed out.", "stayed silent"),
        ("<urlopen error timed out>", "stayed silent"),
        ("('Connection aborted.', ConnectionResetError(104, 'reset'))", "broke off the connection"),
        ("[SSL: CERTIFICATE_VERIFY_FAILED] certificate verify failed", "cannot be trusted"),
        ("IncompleteRead(10 bytes read, 30 more expected)", "after 10 of 40 bytes"),
        ("Downloaded 10 bytes, expected 40 bytes", "after 10 of 40 bytes"),
        ("unable to download video data: HTTP Error 500: Bad", "the answer 500 (Bad)"),
    ],
)
def test_what_libraries_say_of_the_network_is_told_in_our_words(raw, plain):
    assert plain in in_plain_words(raw)
    assert not any(word in in_plain_words(raw) for word in ("Errno", "urlopen", "HTTPS", "[", "'"))


def test_what_we_have_no_words_for_is_left_to_the_caller():
    assert in_plain_words("the public address leads to a private one (10.0.0.1)") is None
