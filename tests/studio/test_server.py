import re
import signal
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

import pytest
from flask import Blueprint

from mimeline.studio.server import HEADERS, MOST_BYTES, PortTaken, cookie_name, serve, studio

BASE = "http://127.0.0.1:8000"
KEY = "the-key"


@pytest.fixture
def stranger(idle_page):
    """A browser that does not know the address."""
    return idle_page.client.application.test_client()


def test_the_address_with_the_key_gives_a_cookie_that_opens_the_page(stranger):
    assert stranger.get("/", base_url=BASE).status_code == 403
    entered = stranger.get(f"/?key={KEY}", base_url=BASE)
    cookie = entered.headers["Set-Cookie"]
    assert entered.status_code == 200 and "HttpOnly" in cookie and "SameSite=Strict" in cookie
    assert stranger.get("/", base_url=BASE).status_code == 200


@pytest.mark.parametrize("path", ["/", "/clips", "/decisions", "/media/film/b_1", "/static/a.js"])
def test_nothing_is_told_to_who_has_no_key(stranger, path):
    for key in ("", "?key=", "?key=guess", "?key=%00", "?key=é"):
        assert stranger.get(f"{path}{key}", base_url=BASE).status_code == 403
    stranger.set_cookie(cookie_name(KEY), "guess", domain="127.0.0.1")
    assert stranger.get(path, base_url=BASE).status_code == 403


@pytest.mark.parametrize(
    "host",
    ["evil.example", "127.0.0.1.evil.example:8000", "evil.example@127.0.0.1", "[::1", "0.0.0.0"],
)
def test_a_name_that_is_made_to_point_here_is_refused(idle_page, host):
    client = idle_page.client
    for path in ("/", f"/?key={KEY}", "/clips"):
        assert client.get(path, headers={"Host": host}).status_code in (400, 403)


def test_a_tunnel_may_end_on_another_port(idle_page):
    client = idle_page.client
    client.get(f"/?key={KEY}", base_url="http://localhost:9000")
    assert client.get("/clips", base_url="http://localhost:9000").status_code == 200


@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"Origin": "null"},
        {"Origin": "http://evil.example"},
        {"Origin": "http://127.0.0.1:9999"},
        {"Origin": BASE, "Sec-Fetch-Site": "cross-site"},
        {"Origin": BASE, "Sec-Fetch-Site": "same-site"},
    ],
)
def test_a_post_from_another_page_changes_nothing(idle_page, headers):
    assert idle_page.decide("b_1", (True, "occlusion"), headers=headers).status_code == 403
    assert not idle_page.exclusions.exists()


def test_another_page_cannot_show_our_films(idle_page):
    foreign = {"Sec-Fetch-Site": "same-site"}  # another port of this machine
    assert idle_page.get("/media/film/b_1", headers=foreign).status_code == 403


def test_posts_are_json_and_small(idle_page):
    headers = {"Origin": BASE}
    form = idle_page.client.post(
        "/decisions", data={"clip_id": "b_1"}, base_url=BASE, headers=headers
    )
    assert form.status_code == 415
    large = idle_page.decide("b_1", (True, "x" * MOST_BYTES))
    assert large.status_code == 413
    broken = idle_page.client.post(
        "/decisions", data="{", content_type="application/json", base_url=BASE, headers=headers
    )
    deep = idle_page.client.post(
        "/decisions",
        data="[" * (MOST_BYTES - 1),
        content_type="application/json",
        base_url=BASE,
        headers=headers,
    )
    assert broken.status_code == deep.status_code == 400 and not idle_page.exclusions.exists()


@pytest.mark.parametrize(
    "path",
    ["/", f"/?key={KEY}", "/clips", "/clips/none", "/media/film/b_1", "/static/review.js", "/no"],
)
def test_every_answer_is_sealed(idle_page, path):
    answers = [idle_page.get(path), idle_page.client.get(path, base_url="http://evil.example")]
    for answer in answers:
        assert {name: answer.headers.get(name) for name in HEADERS} == HEADERS
    policy = HEADERS["Content-Security-Policy"]
    assert policy.startswith("default-src 'none'") and "unsafe" not in policy


@pytest.mark.parametrize(
    "name",
    [
        "none",
        "e_1",
        "../b_1",
        "..%2Fb_1",
        "%2e%2e%2f%2e%2e%2fclips.parquet",
        "b_1%00",
        "b_1.mp4",
        "%2Fetc%2Fpasswd",
        "..\\b_1",
        "",
    ],
)
def test_only_listed_films_are_served(idle_page, name):
    assert idle_page.get(f"/media/film/{name}").status_code == 404


def test_no_folder_is_listed(idle_page):
    for path in ("/media", "/media/", "/media/film", "/media/film/", "/static/", "/static/../x"):
        assert idle_page.get(path).status_code == 404


def test_a_film_that_is_a_link_out_of_the_run_is_not_served(page, results, tmp_path):
    secret = tmp_path / "secret.mp4"
    secret.write_bytes(b"secret")
    film = results / "fetch" / "00" / "media" / "b_1.mp4"
    film.unlink()
    film.symlink_to(secret)
    assert page().get("/media/film/b_1").status_code == 404


def test_a_film_that_was_removed_meanwhile_is_said_to_be(page, results):
    page = page()
    (results / "fetch" / "00" / "media" / "b_1.mp4").unlink()
    answer = page.get("/media/film/b_1")
    assert answer.status_code == 404 and "no longer there" in answer.text


def test_a_part_of_a_film_is_served(idle_page, results):
    film = (results / "fetch" / "00" / "media" / "-a_1.mp4").read_bytes()
    whole = idle_page.get("/media/film/-a_1")
    assert (whole.status_code, whole.data, whole.mimetype) == (200, film, "video/mp4")
    part = idle_page.get("/media/film/-a_1", headers={"Range": "bytes=100-199"})
    assert (part.status_code, part.data) == (206, film[100:200])
    assert part.headers["Content-Range"] == f"bytes 100-199/{len(film)}"
    beyond = idle_page.get("/media/film/-a_1", headers={"Range": "bytes=999999-"})
    assert beyond.status_code == 416


def test_a_port_in_use_is_a_plain_error(idle_page):
    app = idle_page.client.application
    with pytest.raises(PortTaken, match=r"127\.0\.0\.1:99999.*--port"):
        serve(lambda key: app, 99999, open_browser=False, say=lambda text: None)


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM])
def test_the_command_serves_until_it_is_ended_and_says_how_to_go_on(results, exclusions, end):
    exclusions.parent.mkdir()
    exclusions.write_text("clip_id,reason\nb_1,occlusion\nelsewhere,beard\n")
    command = [sys.executable, "-c", "from mimeline.cli import main; main()", "review"]
    command += ["--results", str(results), "--exclusions", str(exclusions), "--no-browser"]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        address = re.search(r"http://127\.0\.0\.1:\d+/\?key=\S+", child.stdout.readline())[0]
        with urllib.request.urlopen(address, timeout=60) as answer:
            assert answer.status == 200 and answer.headers["Server"] == "mimeline"
        with pytest.raises(urllib.error.HTTPError, match="403"):
            urllib.request.urlopen(address.partition("?")[0], timeout=60)
        child.send_signal(end)
        said, complaint = child.communicate(timeout=60)
    finally:
        child.kill()
    assert child.returncode == 0 and complaint == ""
    assert "1 clip looked at, 1 left out" in said and "1 clip besides" in said
    assert f"snakemake --cores 2 --config 'select={{exclusions: {exclusions}}}'" in said


def test_a_page_that_forgets_to_check_is_checked_all_the_same():
    careless = Blueprint("careless", __name__)
    careless.post("/", endpoint="write")(lambda: "written")
    careless.get("/", endpoint="tell")(lambda: "told")
    client = studio(careless, {}, root=Path(), key=KEY).test_client()
    assert client.get("/", base_url=BASE).status_code == 403
    client.get(f"/?key={KEY}", base_url=BASE)
    ours = {"Origin": BASE}
    assert client.post("/", json={}, base_url=BASE, headers=ours).text == "written"
    assert client.post("/", data={"a": 1}, base_url=BASE, headers=ours).status_code == 415
    assert client.post("/", json={}, base_url=BASE).status_code == 403
