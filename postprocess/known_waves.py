"""Waves of a piston in a tank by potential flow in which nothing is small: what a paddle that moves as linear theory says really
makes. Coordinates along the tank go with the paddle, upright ones with the surface (differences of second order and Chebyshev's
polynomials), in time the method of Runge and Kutta; a zone at the end takes the waves. What the disc of a gauge takes of waves.
No program of its own; study_waves.py runs it.
"""

import math

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import spsolve
from scipy.special import jv

from study import GRAVITY

NODES, PER_LENGTH, PER_PERIOD = 9, 40, 40  # over the depth, per wavelength, steps per period
WAVES, ZONE, PERIODS = 3.5, 2.0, 16  # wavelengths of free water and of the zone; duration


def chebyshev():
    """Places from 1 (surface) to 0 and the matrix of the first derivative there (Trefethen, 2000)."""
    n = NODES - 1
    x = np.cos(np.pi * np.arange(n + 1) / n)
    c = np.r_[2, np.ones(n - 1), 2] * (-1.0) ** np.arange(n + 1)
    off = x[:, None] - x[None]
    d = np.outer(c, 1 / c) / (off + np.eye(n + 1))
    return (x + 1) / 2, 2 * (d - np.diag(d.sum(axis=1)))


def wave_numbers(frequencies, depth):
    """Of linear waves, 1/m, of an array of angular frequencies (Newton's method from Eckart's approximation)."""
    deep = np.asarray(frequencies) ** 2 * depth / GRAVITY
    kd = deep / np.sqrt(np.tanh(deep))
    for _ in range(12):
        t = np.tanh(kd)
        kd = kd - (kd * t - deep) / (t + kd * (1 - t * t))
    return kd / depth


def share_seen(k, spacing, radius, dimensions):
    """What a gauge of height has of the amplitude of waves: the mean over its disc or segment with the weight 1 - d²/R², of
    particles that are cubes (inputs/README.md, Gauges)."""
    a, cube = k * radius, np.sinc(k * spacing / (2 * np.pi))
    return cube * (8 * jv(2, a) / a**2 if dimensions == 3 else 3 * (np.sin(a) - a * np.cos(a)) / a**3)


def differences(n):
    """First and second derivative on n + 1 places from 0 to 1."""
    first = sparse.diags([-0.5, 0.5], [-1, 1], shape=(n + 1, n + 1)).tolil()
    second = sparse.diags([1.0, -2.0, 1.0], [-1, 0, 1], shape=(n + 1, n + 1)).tolil()
    first[0, :3], first[n, n - 2:] = [-1.5, 2, -0.5], [0.5, -2, 1.5]
    second[0, :4], second[n, n - 3:] = [2, -5, 4, -1], [-1, 4, -5, 2]
    return first.tocsr() * n, second.tocsr() * n * n


class Piston:
    """With Madsen's second harmonic, and a start over two periods."""

    def __init__(self, height, depth, k):
        kd, self.omega = k * depth, math.sqrt(GRAVITY * k * math.tanh(k * depth))
        transfer = 2 * (math.cosh(2 * kd) - 1) / (math.sinh(2 * kd) + 2 * kd)
        self.first = height / transfer / 2
        self.second = height**2 / (32 * depth) * (3 * math.cosh(kd) / math.sinh(kd) ** 3 - 2 / transfer)
        self.ramp = 4 * math.pi / self.omega

    def at(self, time):
        u, w = min(time / self.ramp, 1), self.omega
        grown, growth = u * u * (3 - 2 * u), 6 * (u - u * u) / self.ramp
        place = self.first * math.sin(w * time) + self.second * math.sin(2 * w * time)
        speed = w * (self.first * math.cos(w * time) + 2 * self.second * math.cos(2 * w * time))
        return grown * place, growth * place + grown * speed


class IrregularPiston:
    """JONSWAP by sines, as the program moves it (wave_theory.cpp), with phases of its own."""

    def __init__(self, height, depth, k, seed):
        self.omega = math.sqrt(GRAVITY * k * math.tanh(k * depth))
        self.ramp, random, bands = 4 * math.pi / self.omega, np.random.default_rng(seed), 128
        ratio = 0.5 + 2 / bands * (np.arange(bands) + random.random(bands))
        off = (ratio - 1) / np.where(ratio <= 1, 0.07, 0.09)
        amplitude = np.sqrt(np.exp(-1.25 / ratio**4) / ratio**5 * 3.3 ** np.exp(-off**2 / 2))
        amplitude *= height / 4 / math.sqrt((amplitude**2).sum() / 2)
        self.frequencies, self.phases = self.omega * ratio, 2 * math.pi * random.random(bands)
        kd = wave_numbers(self.frequencies, depth) * depth
        self.amplitudes = amplitude * (np.sinh(2 * kd) + 2 * kd) / (2 * np.cosh(2 * kd) - 2)

    def at(self, time):
        u, phase = min(time / self.ramp, 1), self.frequencies * time + self.phases
        grown, growth = u * u * (3 - 2 * u), 6 * (u - u * u) / self.ramp
        place = float((self.amplitudes * np.sin(phase)).sum())
        speed = float((self.frequencies * self.amplitudes * np.cos(phase)).sum())
        return grown * place, growth * place + grown * speed


class SolitaryPiston:
    """By Goring's equation, as the program moves it (paddle_motion.cpp); places from the middle of the stroke."""

    def __init__(self, height, depth):
        e = height / depth
        self.kappa = math.sqrt(3 * e / 4) * (1 - 5 * e / 8 + 71 * e**2 / 128) / depth
        self.celerity = math.sqrt(GRAVITY * depth * (1 + e - e**2 / 20 - 3 * e**3 / 70))
        self.parts = e, -e**2 / 4 - 17 * e**3 / 80, 101 * e**3 / 400
        self.duration, self.stroke = 2 / (self.kappa * self.celerity) * (3.8 + e), 2 * sum(self.parts) / self.kappa

    def solved(self, way):
        a, b, c = self.parts
        x = 0.0
        for _ in range(40):
            t = math.tanh(self.kappa * (way - x))
            x -= (x - (a * t + b * t**3 + c * t**5) / self.kappa) / (1 + (a + 3 * b * t**2 + 5 * c * t**4) * (1 - t * t))
        return x

    def place(self, time):
        half = self.celerity * self.duration / 2
        way = self.celerity * min(max(time, 0), self.duration) - half
        return self.solved(way) / self.solved(half) * self.stroke / 2

    def at(self, time):
        step = 1e-4
        return self.place(time), (self.place(time + step) - self.place(time - step)) / (2 * step)


class Tank:
    """From the piston to a wall at `long`, before which a zone of that length takes the waves."""

    def __init__(self, piston, depth, spacing, long, zone=0.0):
        self.depth, self.long, self.piston = depth, long, piston
        n = round(long / spacing)
        self.xi = np.linspace(0, 1, n + 1)
        self.dx, self.dxx = differences(n)
        sigma, ds = chebyshev()
        self.sigma = np.tile(sigma, n + 1)
        upright, across = sparse.identity(NODES), sparse.identity(n + 1)
        self.along, self.along2 = (sparse.kron(d, upright, "csr") for d in (self.dx, self.dxx))
        self.up, self.up2 = (sparse.kron(across, sparse.csr_matrix(d), "csr") for d in (ds, ds @ ds))
        self.both = (self.along @ self.up).tocsr()
        j, i = np.arange((n + 1) * NODES) % NODES, np.arange((n + 1) * NODES) // NODES
        self.top, self.bottom = j == 0, j == NODES - 1
        inner = ~self.top & ~self.bottom
        self.left, self.ends = inner & (i == 0), inner & ((i == 0) | (i == n))
        self.inside = inner & ~self.ends
        self.damping = np.zeros(n + 1)
        if zone > 0:
            self.damping = np.clip((self.xi * long - long + zone) / zone, 0, 1) ** 2 * 3 * piston.omega / math.pi

    def potential(self, eta, surface, speed, width):
        """Laplace's equation: `surface` given on top, the piston's speed at its face, nothing through floor and end."""
        depth = self.depth + eta
        slope, bend = self.dx @ eta / width / depth, self.dxx @ eta / width**2 / depth
        r, q, z = (np.repeat(a, NODES) for a in (slope, bend, 1 / depth**2))
        s, diagonal = self.sigma, sparse.diags
        matrix = (diagonal(self.inside / width**2) @ self.along2 - diagonal(2 * self.inside * s * r / width) @ self.both
                  + diagonal(self.inside * (s * s * r * r + z)) @ self.up2 + diagonal(self.inside * s * (2 * r * r - q)) @ self.up
                  + diagonal(1.0 * self.top) + diagonal(1.0 * self.bottom) @ self.up
                  + diagonal(self.ends / width) @ self.along - diagonal(self.ends * s * r) @ self.up)
        right = np.zeros(len(s))
        right[self.top], right[self.left] = surface, speed
        return spsolve(matrix.tocsc(), right)

    def rate(self, time, state):
        """Of level and potential of the surface, at places that go with the piston."""
        eta, surface = state
        place, speed = self.piston.at(time)
        width = self.long - place
        phi = self.potential(eta, surface, speed, width)
        rise, slope, along = (self.up @ phi)[self.top] / (self.depth + eta), self.dx @ eta / width, self.dx @ surface / width
        going = speed * (1 - self.xi)
        return np.stack([rise * (1 + slope**2) - along * slope + going * slope - self.damping * eta,
                         -GRAVITY * eta - along**2 / 2 + rise**2 * (1 + slope**2) / 2 + going * along - self.damping * surface])


    def levels(self, places, dt, steps):
        """Times, and a row of levels at these places for each."""
        state, rows = np.zeros((2, len(self.xi))), []
        for n in range(steps):
            time = n * dt
            one = self.rate(time, state)
            two = self.rate(time + dt / 2, state + dt / 2 * one)
            three = self.rate(time + dt / 2, state + dt / 2 * two)
            state = state + dt / 6 * (one + 2 * two + 2 * three + self.rate(time + dt, state + dt * three))
            if n % 5 == 0:  # against waves of two places
                state[:, 2:-2] -= 0.3 / 16 * np.diff(state, 4, axis=1)
            place = self.piston.at(time + dt)[0]
            rows.append(np.interp(places, place + self.xi * (self.long - place), state[0]))
        return dt * np.arange(1, steps + 1), np.array(rows)


def first_harmonic_of_piston(height, length, depth):
    """Over that of linear theory, in the mean over places from 1 to 2.75 wavelengths and over the last four periods."""
    piston = Piston(height, depth, 2 * math.pi / length)
    omega = piston.omega
    tank = Tank(piston, depth, length / PER_LENGTH, (WAVES + ZONE) * length, ZONE * length)
    times, levels = tank.levels(np.arange(1, WAVES - 0.74, 0.25) * length, 2 * math.pi / omega / PER_PERIOD, PERIODS * PER_PERIOD)
    t, late = times[-4 * PER_PERIOD:], levels[-4 * PER_PERIOD:]
    amplitudes = 2 / len(t) * np.hypot(np.cos(omega * t) @ late, np.sin(omega * t) @ late)
    return float(np.mean(2 * amplitudes / height))


def levels_of_solitary(height, depth, places):
    """Times and levels at places, in depths from the middle of the stroke."""
    piston = SolitaryPiston(height, depth)
    tank = Tank(piston, depth, depth / 12, (places[-1] + 8) * depth)
    dt = 0.025 * math.sqrt(depth / 0.75)
    seconds = piston.duration / 2 + (places[-1] + 3) * depth / piston.celerity
    return tank.levels(np.array(places) * depth, dt, round(seconds / dt))


def levels_of_irregular(height, length, depth, periods, seed=1):
    """Times and levels at one wavelength of the peak from the paddle."""
    piston = IrregularPiston(height, depth, 2 * math.pi / length, seed)
    tank = Tank(piston, depth, length / 60, (2.2 + 1.5) * length, 1.5 * length)
    times, levels = tank.levels(np.array([length]), 2 * math.pi / piston.omega / PER_PERIOD, periods * PER_PERIOD)
    return times, levels[:, 0]
