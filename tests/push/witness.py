#!/usr/bin/env python3
"""A second way to fit a push test: every true force is an unknown of its own, and Gauss-Newton finds all of them at once. It shares
nothing with host/push/fit.c, which has the forces eliminated.

usage: witness.py PUSH.csv FORCE_ERROR_LB DIAL_ERROR_IN

The file: columns test, load, force (lb), displacement (in); one test up and down, forces at or above 0, the largest one read once. Says
K in lb/in and rho with their 95 % intervals (where the least squares have risen by 1.96^2) and the least squares."""
import csv
import sys


def solve(matrix, right):
    """Gauss with pivots."""
    n = len(right)
    rows = [matrix[i][:] + [right[i]] for i in range(n)]
    for c in range(n):
        pivot = max(range(c, n), key=lambda r: abs(rows[r][c]))
        rows[c], rows[pivot] = rows[pivot], rows[c]
        for r in range(c + 1, n):
            factor = rows[r][c] / rows[c][c]
            if factor:
                for k in range(c, n + 1):
                    rows[r][k] -= factor * rows[c][k]
    x = [0.0] * n
    for r in reversed(range(n)):
        x[r] = (rows[r][n] - sum(rows[r][k] * x[k] for k in range(r + 1, n))) / rows[r][r]
    return x


def displacement(force, top, a, rho):
    """Each reading's way from the true forces: up to the top, then back by rho of it."""
    return [a * f if i <= top else a * force[top] + rho * a * (f - force[top]) for i, f in enumerate(force)]


def fit(force, moved, top, force_error, moved_error, a, rho, hold):
    """Least squares over a, rho, zero and all true forces; `hold`: of "a" and "rho" the one that stays. Returns (chi2, a, rho)."""
    true, zero, n = force[:], moved[0], len(force)
    free = [name for name in ("a", "rho") if name != hold]

    def residuals(a, rho, zero, true):
        way = displacement(true, top, a, rho)
        return [(moved[i] - zero - way[i]) / moved_error for i in range(n)] + [(force[i] - true[i]) / force_error for i in range(n)]

    def pack():
        return [a / scale["a"] if name == "a" else rho for name in free] + [zero] + true

    def unpack(x):
        values = dict(zip(free, x))
        return (values["a"] * scale["a"] if "a" in values else a, values.get("rho", rho), x[len(free)], x[len(free) + 1:])

    scale = {"a": abs(a)}
    for _ in range(60):
        x = pack()
        r0 = residuals(*unpack(x))
        columns = []
        for k in range(len(x)):
            step = 1e-6 * max(1.0, abs(x[k]))
            up, down = x[:], x[:]
            up[k] += step
            down[k] -= step
            columns.append([(p - m) / (2 * step) for p, m in zip(residuals(*unpack(up)), residuals(*unpack(down)))])
        normal = [[sum(p * q for p, q in zip(c, d)) for d in columns] for c in columns]
        move = solve(normal, [-sum(p * q for p, q in zip(c, r0)) for c in columns])
        a, rho, zero, true = unpack([p + q for p, q in zip(x, move)])
        if max(abs(m) for m in move) < 1e-8:
            break
    return sum(r * r for r in residuals(a, rho, zero, true)), a, rho


def end(chi2, best, at, sign, step):
    """Where chi2 has risen by 1.96^2, by halving."""
    low, high = 0.0, step
    while chi2(at + sign * high) - best < 1.96 ** 2:
        low, high = high, 2 * high
    for _ in range(14):
        middle = 0.5 * (low + high)
        if chi2(at + sign * middle) - best < 1.96 ** 2:
            low = middle
        else:
            high = middle
    return at + sign * high


def main():
    rows = list(csv.reader(open(sys.argv[1])))[1:]
    force, moved = [float(r[2]) for r in rows], [float(r[3]) for r in rows]
    force_error, moved_error = float(sys.argv[2]), float(sys.argv[3])
    top = force.index(max(force))

    def best_of(a, rho, hold=None):
        return fit(force, moved, top, force_error, moved_error, a, rho, hold)

    best, a, rho = best_of((moved[top] - moved[0]) / force[top], 0.8)
    step = 0.01 * a
    a_low, a_high = (end(lambda v: best_of(v, rho, "a")[0], best, a, s, step) for s in (-1, 1))
    r_low, r_high = (end(lambda v: best_of(a, v, "rho")[0], best, rho, s, 0.02) for s in (-1, 1))
    print("K %.8g %.8g %.8g" % (1 / a, 1 / a_high, 1 / a_low))
    print("rho %.8g %.8g %.8g" % (rho, r_low, r_high))
    print("chi2 %.8g" % best)


main()
