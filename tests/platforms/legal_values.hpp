// Random values that a component takes: within its bounds, unit quaternions and directions of length 1, inertias of
// bodies that can be. Drawn with operations that every platform rounds alike.
#pragma once

#include "attitude/random.hpp"
#include "fmi/declaration.hpp"

/// Up to as many numbers as a component has; a std::vector would want the C++ runtime.
class Values {
public:
    explicit Values(std::size_t size) : size_(size) {}
    Values(const double* begin, std::size_t size) : size_(size) {
        for (std::size_t i = 0; i < size; ++i) x_[i] = begin[i];
    }
    std::size_t size() const { return size_; }
    double* data() { return x_; }
    const double* data() const { return x_; }
    double& operator[](std::size_t i) { return x_[i]; }
    double operator[](std::size_t i) const { return x_[i]; }

private:
    std::size_t size_;
    double x_[adcs::Table::scalar_capacity]{};
};

class LegalValues {
public:
    LegalValues(std::uint64_t seed, std::uint64_t draw)
        : random_(adcs::Stream("LegalValues").draw(static_cast<std::int64_t>(seed), static_cast<std::int64_t>(draw))) {}

    double between(double low, double high) { return low + (high - low) * random_.uniform(); }
    int integer(int low, int high) { return low + static_cast<int>(random_.uniform() * (high - low + 1)); }

    /// The start value times a factor; where there is nothing to scale, something small. Matrices keep their structure.
    Values parameter(const adcs::Variable& v) {
        Values x = start(v);
        if (v.kind == adcs::Kind::unit_quaternion) return around(v, x, 0.5);
        const double factor = between(0.5, 1.5);
        double largest = 0.0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            x[i] *= factor;
            largest = adcs::abs(x[i]) > largest ? adcs::abs(x[i]) : largest;
        }
        if (v.kind == adcs::Kind::inertia) {
            const double more = between(0.0, 0.2) * (x[0] + x[4] + x[8]);
            for (std::size_t i = 0; i < 9; i += 4) x[i] += more;
        }
        if (largest == 0.0 && v.cols == 0) x = around(v, x, 0.3);
        return within_bounds(v, x);
    }

    /// x moved by so many nominal values at most. What has length 1 keeps it.
    Values around(const adcs::Variable& v, Values x, double distance) {
        const std::size_t length = v.cols == 0 ? x.size() : v.cols;
        for (std::size_t row = 0; row < x.size(); row += length) {
            const bool unit = length > 1 && adcs::abs(square(x, row, length) - 1.0) < 1e-9;
            for (std::size_t i = row; i < row + length; ++i) {
                x[i] += distance * (unit ? 1.0 : v.nominal) * between(-1.0, 1.0);
            }
            if (!unit) continue;
            const double size = adcs::sqrt(square(x, row, length));
            for (std::size_t i = row; i < row + length; ++i) x[i] /= size;
        }
        return within_bounds(v, x);
    }

    static Values start(const adcs::Variable& v) { return Values(static_cast<const double*>(v.data), v.size); }

private:
    static double square(const Values& x, std::size_t begin, std::size_t length) {
        double sum = 0.0;
        for (std::size_t i = begin; i < begin + length; ++i) sum += x[i] * x[i];
        return sum;
    }
    static Values within_bounds(const adcs::Variable& v, Values x) {
        const Values otherwise = start(v);
        for (std::size_t i = 0; i < x.size(); ++i) {
            if (!(x[i] > v.above)) x[i] = otherwise[i];
            if (x[i] < v.min) x[i] = v.min;
            if (x[i] > v.max) x[i] = v.max;
        }
        return x;
    }

    adcs::Random random_;
};
