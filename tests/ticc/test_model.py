import logging

import numpy as np
import pytest
from scipy.stats import multivariate_normal
from sklearn.base import clone
from sklearn.metrics import adjusted_rand_score
from threadpoolctl import threadpool_limits

from mimeline.ticc import TICC
from mimeline.ticc.frames import ArrayFrames


def split(values, lengths):
    return np.split(values, np.cumsum(lengths)[:-1])


def test_planted_motions_are_found_over_many_sequences(series, fitted):
    _, _, truth = series
    assert adjusted_rand_score(truth, fitted.labels_) > 0.9


def test_motions_of_unseen_sequences_are_found(plant, fitted):
    X, truth = plant([150, 70, 300], seed=5)
    assert adjusted_rand_score(truth, fitted.predict(X, [150, 70, 300])) > 0.9


def test_every_frame_is_labelled_in_sequences_shorter_than_the_window_too(series, fitted):
    X, lengths, _ = series
    labels, margins = fitted.decode(X, lengths)
    assert labels.shape == margins.shape == (len(X),)
    assert labels.dtype == np.int64
    assert set(labels) == {0, 1, 2}
    assert np.isfinite(margins).all() and (margins >= 0).all()
    assert fitted.predict(X[:1]).shape == (1,)


def test_labels_of_fit_are_those_that_predict_gives(series, fitted):
    X, lengths, _ = series
    assert np.array_equal(fitted.labels_, fitted.predict(X, lengths))


def test_sequences_are_labelled_alike_in_any_order_and_any_company(series, fitted):
    X, lengths, _ = series
    alone = [fitted.predict(part) for part in split(X, lengths)]
    order = np.random.default_rng(0).permutation(len(lengths))
    mixed = np.concatenate([split(X, lengths)[i] for i in order])
    together = split(fitted.predict(mixed, lengths[order]), lengths[order])
    for position, i in enumerate(order):
        assert np.array_equal(together[position], alone[i])


def test_what_lies_in_the_next_sequence_changes_no_estimate(plant):
    """Means and precisions see full windows only, and those lie within a sequence."""
    X, _ = plant([200, 200], seed=3)
    far = X.copy()
    far[200:] += 50.0
    model = TICC(n_clusters=2, window=5, sparsity=1e-3).fit(far, [200, 200])
    joined = TICC(n_clusters=2, window=5, sparsity=1e-3).fit(far)
    near = model.means_.reshape(2, 5, 3).mean(axis=(1, 2))
    assert sorted(np.round(near)) == pytest.approx([0, 50], abs=1)
    assert np.ptp(model.labels_[:200]) == np.ptp(model.labels_[200:]) == 0
    straddling = 50.0**2 * 2 / 200  # what two windows over the border would add to a variance
    assert np.linalg.inv(model.precisions_).max() < straddling / 5
    assert np.linalg.inv(joined.precisions_).max() > straddling / 2


def test_literal_null_sequences_have_a_cluster_of_their_own(series, fitted):
    X, lengths, truth = series
    model = TICC(n_clusters=3, window=4, beta=5.0, boundary="paper", null_value=-9.0)
    labels, margins = model.fit(X, lengths).decode(X, lengths)
    assert len(model.means_) == 4
    assert np.allclose(model.means_[3], -9.0, atol=0.2)
    assert labels.shape == margins.shape == (len(X),) and np.isfinite(margins).all()
    assert np.array_equal(labels, model.labels_)
    assert np.mean(labels == 3) < 0.02  # few windows are more null than not
    found = adjusted_rand_score(truth, labels)  # windows that straddle a border cost a cluster
    assert 0.4 < found < adjusted_rand_score(truth, fitted.labels_)
    again = TICC(n_clusters=3, window=4, beta=5.0, boundary="paper", null_value=-9.0)
    start = np.where(np.arange(len(X)) % 50 == 0, 3, labels)  # as labels_ may hold it
    assert np.mean(again.fit(X, lengths, start).labels_ == labels) > 0.95
    alone = TICC(n_clusters=3, window=4, beta=5.0, boundary="paper").fit(X)
    assert len(alone.means_) == 3  # no border, no null


def test_one_sequence_has_no_null_however_it_is_cut_to_search_a_start(plant):
    X, _ = plant([5000], seed=4)
    paper = TICC(n_clusters=3, window=4, max_iter=4, boundary="paper", null_value=0.0).fit(X)
    assert len(paper.means_) == 3
    assert np.array_equal(paper.labels_, TICC(n_clusters=3, window=4, max_iter=4).fit(X).labels_)


def test_null_sequences_are_those_of_a_series_written_out(series):
    X, lengths, _ = series
    null = np.full((100, 3), -9.0)
    parts = [part for clip in split(X, lengths) for part in (clip, null)][:-1]
    real = np.repeat(np.arange(len(parts)) % 2 == 0, [len(part) for part in parts])
    paper = TICC(n_clusters=3, window=4, boundary="paper", null_value=-9.0, standardise=False)
    start = (X[:, 0] > 1).astype(int)
    paper.fit(X, lengths, start=start)
    written = np.full(len(real), 3)
    written[real] = start
    joined = TICC(n_clusters=4, window=4, standardise=False)
    joined.fit(np.concatenate(parts), start=written)
    assert np.array_equal(paper.labels_, joined.labels_[real])
    assert paper.objective_ == pytest.approx(joined.objective_, rel=1e-6)


def test_trailing_windows_label_the_same_windows_half_a_window_later(plant):
    X, _ = plant([800], seed=2)
    start = np.repeat([0, 1, 2, 0], 200)
    middle = TICC(n_clusters=3, window=5, max_iter=6).fit(X, start=start)
    late = TICC(n_clusters=3, window=5, max_iter=6, alignment="trailing")
    late.fit(X, start=np.roll(start, 2))
    assert np.mean(late.labels_[4:] == middle.labels_[2:-2]) > 0.99


@pytest.mark.parametrize("boundary", ["mask", "paper"])
def test_a_fit_goes_on_from_another_one(boundary, plant):
    X, _ = plant([180, 180], seed=11)
    given = {"n_clusters": 3, "window": 4, "beta": 5.0, "boundary": boundary, "null_value": -4.0}
    first = TICC(**given).fit(X, [180, 180])
    again = TICC(**given).fit(X, [180, 180], start=first)
    assert again.n_iter_ <= 3
    assert again.objective_ <= first.objective_ * (1 + 1e-6)
    with pytest.raises(ValueError, match="start: found a fit of"):
        TICC(**given | {"n_clusters": 5}).fit(X, [180, 180], start=first)


def test_a_model_of_one_sequence_knows_no_null_between_others(plant):
    X, _ = plant([600], seed=2)
    model = TICC(n_clusters=3, window=4, boundary="paper").fit(X)
    together = model.predict(X, [200, 250, 150])
    alone = [model.predict(part) for part in split(X, [200, 250, 150])]
    assert np.array_equal(together, np.concatenate(alone))


def test_frames_that_look_like_the_null_sequences_are_told_of(plant, caplog):
    X, _ = plant([200, 200], seed=2)
    X[50:80] = -9.0
    model = TICC(n_clusters=2, window=3, boundary="paper", null_value=-9.0)
    with caplog.at_level(logging.WARNING):
        model.fit(X, [200, 200])
    lost = np.count_nonzero(model.labels_ == 2)
    assert lost > 20
    assert f"{lost} frames lie in the cluster of the null sequences" in caplog.text


def test_the_estimator_is_scikit_learns(fitted):
    fresh = clone(fitted).set_params(beta=7.0)
    assert not hasattr(fresh, "means_")
    assert fresh.get_params() == fitted.get_params() | {"beta": 7.0}


class Failing(ArrayFrames):
    """Frames of a disk that fails: blocks can still be read, short stretches no more."""

    def read(self, begin, end):
        if end - begin < len(self.X):
            raise OSError("gone")
        return super().read(begin, end)


def test_it_clusters_as_scikit_learn_asks(series, fitted):
    X, lengths, _ = series
    assert np.array_equal(clone(fitted).fit_predict(X, lengths=lengths), fitted.labels_)


def test_a_refit_that_fails_leaves_no_half_of_a_model(series):
    X, lengths, _ = series
    model = TICC(n_clusters=3, window=4, max_iter=2).fit(X, lengths)
    with pytest.raises(OSError, match="gone"):
        model.fit(Failing(X * 2, lengths))
    with pytest.raises(ValueError, match="not fitted"):
        model.predict(X)


def test_labels_to_start_from_are_kept_where_they_are_right(series, fitted):
    X, lengths, _ = series
    order = np.array([2, 0, 1])
    again = TICC(n_clusters=3, window=4, beta=5.0).fit(X, lengths, order[fitted.labels_])
    assert again.n_iter_ <= 2
    assert np.mean(again.labels_ == order[fitted.labels_]) > 0.99
    with pytest.raises(ValueError, match="start: found labels 0 to 5, expected 0 to 2"):
        TICC(n_clusters=3).fit(X, lengths, fitted.labels_ + 3 * (fitted.labels_ == 2))


def test_a_type_of_number_changes_no_label(series, fitted):
    X, lengths, _ = series
    for kind in (np.float32, np.float16, ">f8", np.longdouble):
        assert np.mean(fitted.predict(X.astype(kind), lengths) == fitted.labels_) > 0.999
    assert np.array_equal(fitted.predict(np.asfortranarray(X), lengths), fitted.labels_)
    assert np.array_equal(fitted.predict(np.repeat(X, 2, axis=1)[:, ::2], lengths), fitted.labels_)
    assert fitted.predict(np.zeros((9, 3), dtype=np.uint8)).shape == (9,)


def test_a_dearer_switch_gives_fewer_switches(series, fitted):
    X, lengths, _ = series
    before = np.count_nonzero(np.diff(fitted.labels_))
    held = TICC(n_clusters=3, window=4, beta=50.0)
    for name in ("means_", "precisions_", "center_", "scale_"):
        setattr(held, name, getattr(fitted, name))
    assert np.count_nonzero(np.diff(held.predict(X, lengths))) < before


def test_the_likelihood_of_the_same_motions_exceeds_that_of_others(series, fitted):
    X, lengths, _ = series
    assert fitted.score(X, lengths) > fitted.score(X[:, ::-1], lengths) + 1


def test_a_unit_changes_no_label(series, fitted):
    X, lengths, _ = series
    units = np.array([100.0, 0.01, 1.0])
    model = TICC(n_clusters=3, window=4, beta=5.0, max_iter=15).fit(X * units + 7.0, lengths)
    assert np.array_equal(model.labels_, fitted.labels_)


def test_the_score_is_the_mean_log_density_of_what_each_window_sees(plant):
    X, _ = plant([60, 2, 50], seed=8)
    X = X * [3.0, 0.1, 1.0] + 5.0
    model = TICC(n_clusters=2, window=3, max_iter=4).fit(X, [60, 2, 50])
    densities = []
    for begin, end in ((0, 60), (60, 62), (62, 112)):
        for t in range(begin, end):
            offsets = np.arange(-1, 2)
            inside = (t + offsets >= begin) & (t + offsets < end)
            kept, k = np.repeat(inside, 3), model.labels_[t]
            covariance = np.linalg.inv(model.precisions_[k])[np.ix_(kept, kept)]
            normal = multivariate_normal(model.means_[k][kept], covariance)
            densities.append(normal.logpdf(X[t + offsets[inside]].ravel()))
    assert model.score(X, [60, 2, 50]) == pytest.approx(np.mean(densities))


def test_a_penalised_cost_counts_each_frames_share_of_the_penalty(plant):
    X, _ = plant([400], seed=8)
    start = (np.arange(400) // 100) % 2
    given = {"n_clusters": 2, "window": 3, "sparsity": 0.3, "max_iter": 1, "beta": 1e6}
    paid = TICC(**given).fit(X, start=start)
    bare = TICC(**given, cost="likelihood").fit(X, start=start)
    assert np.ptp(paid.labels_) == np.ptp(bare.labels_) == 0  # no switch is worth its price
    units = np.tile(paid.scale_, 3)
    P = paid.precisions_[paid.labels_[0]] * np.multiply.outer(units, units)
    share = 0.15 * np.abs(P).sum()
    ends = share * 2 / 3  # about: a window that the border cuts has fewer entries
    assert paid.objective_ - bare.objective_ == pytest.approx(398 * share + 2 * ends, rel=0.01)


def test_one_cluster_holds_every_frame_and_nothing_else_is_near(series):
    X, lengths, _ = series
    model = TICC(n_clusters=1, window=4).fit(X, lengths)
    labels, margins = model.decode(X, lengths)
    assert (labels == 0).all() and np.isinf(margins).all()


def test_more_clusters_than_motions_leave_no_nan(series):
    X, lengths, _ = series
    model = TICC(n_clusters=20, window=4, max_iter=5).fit(X, lengths)
    assert np.isfinite(model.means_).all() and np.isfinite(model.precisions_).all()
    assert np.linalg.eigvalsh(model.precisions_).min() > 0


def test_a_seed_gives_one_result(series, fitted):
    X, lengths, _ = series
    again = TICC(n_clusters=3, window=4, beta=5.0, max_iter=15).fit(X, lengths)
    assert again.fingerprint() == fitted.fingerprint()


def test_threads_change_nothing(series, fitted):
    X, lengths, _ = series
    with threadpool_limits(2):
        again = TICC(n_clusters=3, window=4, beta=5.0, max_iter=15).fit(X, lengths)
    assert np.array_equal(again.precisions_, fitted.precisions_)
    assert np.array_equal(again.labels_, fitted.labels_)


def test_a_saved_model_comes_back_whole(series, fitted, tmp_path):
    X, lengths, _ = series
    fitted.save(tmp_path / "new" / "model")
    back = TICC.load(tmp_path / "new" / "model")
    assert back.fingerprint() == fitted.fingerprint()
    assert back.get_params() == fitted.get_params()
    assert np.array_equal(back.predict(X, lengths), fitted.labels_)
    assert (back.objective_, back.n_iter_, back.converged_) == (
        fitted.objective_,
        fitted.n_iter_,
        fitted.converged_,
    )


def test_a_fingerprint_tells_models_apart(fitted, tmp_path):
    fitted.save(tmp_path)
    other = TICC.load(tmp_path)
    assert other.fingerprint() == fitted.fingerprint()
    other.means_[0, 0] += 1e-12  # as another processor may round it
    assert other.fingerprint() == fitted.fingerprint()
    other.labels_[0] += 1
    assert other.fingerprint() != fitted.fingerprint()
    other = TICC.load(tmp_path)
    other.beta = 6.0
    assert other.fingerprint() != fitted.fingerprint()


def test_a_model_of_another_format_is_refused(fitted, tmp_path):
    fitted.save(tmp_path)
    facts = tmp_path / "model.json"
    facts.write_text(facts.read_text().replace('"format": 2', '"format": 99'))
    with pytest.raises(ValueError, match=r"model\.json: found format 99, expected 2"):
        TICC.load(tmp_path)


def test_a_damaged_model_is_refused(fitted, tmp_path):
    fitted.save(tmp_path)
    whole = (tmp_path / "model.npz").read_bytes()
    for damaged in (whole[: len(whole) // 2], b"", b"PK"):
        (tmp_path / "model.npz").write_bytes(damaged)
        with pytest.raises(ValueError):
            TICC.load(tmp_path)
    for text in ("[]", "{}", "{"):
        (tmp_path / "model.json").write_text(text)
        with pytest.raises(ValueError):
            TICC.load(tmp_path)
    with pytest.raises(ValueError, match="found no whole model of TICC"):
        TICC.load(tmp_path / "nowhere")


def test_what_cannot_be_clustered_is_refused_with_its_place(plant):
    X, _ = plant([100])
    bad = X.copy()
    bad[17, 2] = np.nan
    with pytest.raises(ValueError, match="nan at frame 17, channel 2"):
        TICC(n_clusters=2).fit(bad)
    still = X.copy()
    still[:, 1] = 0.3
    with pytest.raises(ValueError, match=r"constant channels \[1\]"):
        TICC(n_clusters=2).fit(still)
    with pytest.raises(ValueError, match="found 6 full windows of 5 frames"):
        TICC(n_clusters=9).fit(X[:10])
    with pytest.raises(ValueError, match="found 0 full windows"):
        TICC(n_clusters=2).fit(X, [4] * 25)
    with pytest.raises(ValueError, match="found a sum of 90, expected 100"):
        TICC(n_clusters=2).fit(X, [60, 30])
    with pytest.raises(ValueError, match="window: found 1200 numbers in a window"):
        TICC(window=400).fit(np.tile(X, (20, 1)))
    with pytest.raises(ValueError, match="put sequences end to end and give their lengths"):
        TICC().fit([X[:50], X[:40]])
    with pytest.raises(ValueError, match="standardise: found 'yes'"):
        TICC(standardise="yes").fit(X)
    with pytest.raises(ValueError, match="beta: found -1"):
        TICC(beta=-1).fit(X)
    for wrong in ({"beta": "3"}, {"n_clusters": 3.0}, {"seed": -1}, {"null_value": np.nan}):
        (name, value), *_ = wrong.items()
        with pytest.raises(ValueError, match=f"{name}: found {value!r}, expected"):
            TICC(**wrong).fit(X)
    with pytest.raises(ValueError, match="boundary: found 'masked', expected one of"):
        TICC(boundary="masked").fit(X)
    with pytest.raises(ValueError, match="not fitted"):
        TICC().predict(X)


def test_a_fitted_model_refuses_what_it_cannot_label(series, fitted):
    X, lengths, _ = series
    bad = X.copy()
    bad[17, 2] = np.inf
    for ask in (fitted.predict, fitted.decode, fitted.score):
        with pytest.raises(ValueError, match="found inf at frame 17, channel 2"):
            ask(bad, lengths)
    with pytest.raises(ValueError, match="found 2 channels, expected 3"):
        fitted.predict(X[:, :2], lengths)


def test_frames_cost_least_on_average_in_their_own_cluster(series, fitted):
    X, lengths, _ = series
    costs = fitted.mean_costs(X, fitted.labels_, lengths)
    assert (costs.argmin(axis=1) == np.arange(3)).all()


def test_mean_costs_of_all_frames_in_one_cluster_are_minus_its_score(series):
    X, lengths, _ = series
    model = TICC(1, window=4, cost="likelihood", standardise=False).fit(X, lengths)
    costs = model.mean_costs(X, np.zeros(len(X), dtype=int), lengths)
    assert costs[0, 0] == pytest.approx(-model.score(X, lengths))


def test_a_cluster_that_no_frame_is_given_has_no_mean_cost(series, fitted):
    X, lengths, _ = series
    costs = fitted.mean_costs(X, np.ones(len(X), dtype=int), lengths)
    assert np.isfinite(costs[1]).all() and np.isnan(costs[[0, 2]]).all()


def test_null_sequences_count_for_no_mean_cost(series):
    X, lengths, _ = series
    model = TICC(2, window=4, boundary="paper", max_iter=3).fit(X, lengths)
    costs = model.mean_costs(X, model.labels_, lengths)
    assert costs.shape == (3, 3)
    assert np.isfinite(costs[:2]).all()
