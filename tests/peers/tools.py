"""PySINDy and SysIdentPy as finders of a missing effect: a fit to a residual, judged on unseen data.

Both get what their authors recommend: PySINDy sequentially thresholded least squares on a custom
library with the threshold chosen on held-back rows; SysIdentPy forward orthogonal regression with an
information criterion. A term counts only if it helps on the held-back rows of the training log.
"""

import contextlib
import io
import warnings

import numpy as np
import pysindy
from sysidentpy.basis_function import Polynomial
from sysidentpy.model_structure_selection import FROLS
from sysidentpy.parameter_estimation import LeastSquares

HELD_BACK = 0.3
"""Share of the training log on which thresholds are chosen."""
WORTH = 0.01
"""A model has to lower the error of held-back rows by this share to be kept."""
STILL = 1e-2
"""A column smaller than this share of the largest of its kind is left out."""
ALIKE = 1.02
"""Errors on held-back rows that differ by less than this factor are alike."""
THRESHOLDS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0]
"""Of columns and residual in units of their own size and of the noise."""


def rms(values):
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def quietly(run, *arguments, **options):
    """Both tools warn and print a lot; what they return is what counts."""
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        return run(*arguments, **options)


def sparse(columns, target, threshold):
    """Coefficients of one sparse fit of PySINDy; `columns` have unit size."""
    labels = [f"f{k}" for k in range(columns.shape[1])]
    model = pysindy.SINDy(
        optimizer=pysindy.STLSQ(threshold=threshold, alpha=1e-3),
        feature_library=pysindy.IdentityLibrary(),
    )
    quietly(model.fit, columns, t=1.0, x_dot=target[:, None], feature_names=labels)
    return model.coefficients()[0]


def pysindy_terms(columns, target, unseen):
    """Fits `target` (in units of noise) by named `columns`.

    Returns the selected terms with the fall of the squared error that each brings alone, the
    largest first, and the prediction for the columns `unseen`.
    """
    # An axis that hardly moves in the training log would be extrapolated without limits.
    size = {label: rms(column) for label, column in columns.items()}
    largest = {}
    for label in columns:
        kind = label.split(":")[0]
        largest[kind] = max(largest.get(kind, 1e-12), size[label])
    labels = [label for label in columns if size[label] > STILL * largest[label.split(":")[0]]]
    size = np.array([size[label] for label in labels])
    train = np.column_stack([columns[label] for label in labels]) / size
    test = np.column_stack([unseen[label] for label in labels]) / size
    # Every third second is held back, so that both parts hold all kinds of motion.
    held = np.arange(len(target)) % 750 >= 750 * (1 - HELD_BACK)
    errors = {}
    for threshold in THRESHOLDS:
        found = sparse(train[~held], target[~held], threshold)
        error = rms(target[held] - train[held] @ found)
        if found.any() and error < (1 - WORTH) * rms(target[held]):
            errors[threshold] = error
    if not errors:
        return [], np.zeros(len(test))
    # The sparsest among those that are about as good as the best.
    best = max(t for t, error in errors.items() if error <= ALIKE * min(errors.values()))
    found = sparse(train, target, best)
    # Alike columns cancel each other with large coefficients, so each is weighed alone.
    alone = (train.T @ target) ** 2 / np.sum(train**2, axis=0)
    gains = sorted(zip(alone[found != 0], np.array(labels)[found != 0]), reverse=True)
    return [(float(gain), str(label)) for gain, label in gains], test @ found


def frols_terms(inputs, target, unseen, degree, lags=2):
    """Fits `target` by polynomials of lagged `inputs` (n, k), as SysIdentPy's NFIR model.

    Returns the regressors in the order of their selection, as lists of (input, lag), and the
    prediction for the inputs `unseen`. Without feedback of the output the prediction is a free run.
    """
    size = np.maximum(np.sqrt(np.mean(inputs**2, axis=0)), 1e-12)
    train, test = inputs / size, unseen / size
    part = int(len(target) * (1 - HELD_BACK))
    fit = lambda x, y: _frols(x, y, degree, lags)
    trial = fit(train[:part], target[:part])
    if trial is None:
        return [], np.zeros(len(test))
    predicted = _run(trial, train[part:])
    if rms(target[part:] - predicted) > (1 - WORTH) * rms(target[part:]):
        return [], np.zeros(len(test))
    model = fit(train, target)
    chosen = [
        [((code // 1000) - 2, code % 1000) for code in regressor if code >= 2000]
        for regressor in model.final_model
    ]
    return chosen, _run(model, test)


def _frols(inputs, target, degree, lags):
    model = FROLS(
        order_selection=True,
        n_info_values=12,
        ylag=1,
        xlag=[list(range(1, lags + 1))] * inputs.shape[1],
        info_criteria="bic",
        estimator=LeastSquares(),
        model_type="NFIR",
        basis_function=Polynomial(degree=degree),
    )
    quietly(model.fit, X=inputs, y=target[:, None])
    return model if len(model.final_model) else None


def _run(model, inputs):
    start = np.zeros((model.max_lag, 1))
    predicted = quietly(model.predict, X=inputs, y=start).ravel()
    return np.nan_to_num(predicted[: len(inputs)])
