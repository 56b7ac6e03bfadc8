/// # QUEST
///
/// The attitude quaternion from three measured unit vectors, Sec. 5.4.3: the solution of Wahba's problem, $q$ with
/// $\sum a_j\lVert y_j - C(q)\,x_j\rVert^2$ smallest, by the algorithm of Shuster and Oh (1981). From
/// $D = \sum a_j\,y_j x_j^T$, $S = D + D^T$, $\sigma = \mathrm{tr}\,D$, $Z = \sum a_j\,y_j\times x_j$,
/// $\kappa = \mathrm{tr}\,\mathrm{adj}\,S$ and $\Delta = \det S$, Newton's method finds the largest root of
///
/// $$p(\lambda) = \lambda^4 - (a + b)\lambda^2 - c\lambda + ab + c\sigma - d$$
/// $$a = \sigma^2 - \kappa, \qquad b = \sigma^2 + Z^T Z, \qquad c = \Delta + Z^T S Z, \qquad d = Z^T S^2 Z$$
///
/// from $\lambda = \sum a_j$ downwards, and the quaternion is proportional to $[\gamma,\ X]$:
///
/// $$\gamma = (\lambda + \sigma)\alpha - \Delta, \qquad X = (\alpha I + (\lambda - \sigma)S + S^2)Z, \qquad
///   \alpha = \lambda^2 - \sigma^2 + \kappa$$
///
/// That vanishes at 180 degrees, so of four reference frames, N and N turned by 180 degrees about each axis, the one with
/// the largest $\gamma$ is used.
///
/// **Sign.** $q$ and $-q$ are the same attitude. The sign is that of the smaller turn from `q_last`, the estimate at the
/// latest multiple of `memory_period`, so it does not jump as long as the body turns by less than 180 degrees in that time;
/// at the start it is that of `q_BN_first`.
///
/// **Collinear vectors** leave the turn about their line unseen. `observability` is $p'(\lambda)/8(\sum a_j)^3$, for
/// exact measurements $(\mu_1+\mu_2)(\mu_2+\mu_3)(\mu_3+\mu_1)/(\mu_1+\mu_2+\mu_3)^3$ with the eigenvalues $\mu$ of
/// $\sum a_j\,x_j x_j^T$: 8/27 at best, 1/4 for two vectors at right angles, 0 for collinear ones. Below `limit` the
/// estimate stays at `q_last`. Directions in N that are collinear to begin with are refused.
#pragma once

#include "attitude/directions.hpp"
#include "fmi/declaration.hpp"
#include "fmi/lifted.hpp"

namespace adcs {

template <class T>
struct Quest {
    static constexpr auto summary = "Attitude quaternion from three unit vectors by QUEST, without jumps of sign";
    static constexpr auto reference =
        "Shuster, Oh, Three-Axis Attitude Determination from Vector Observations, J. Guidance and Control 4(1), 1981; "
        "Thakur, dissertation on adaptive, gyro-free and observer-based attitude control, Sec. 5.4.3";

    Directions<T> directions_B{{0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}, {0.6, 0.8, 0.0}};
    Directions<T> directions_N{{0.0, 0.0, 1.0}, {1.0, 0.0, 0.0}, {1.0, 1.0, 0.0}};
    Weights<T> weights{1.0, 1.0, 1.0};
    Quat<T> q_BN_first{1.0, 0.0, 0.0, 0.0};
    T memory_period = 0.1, limit = 1e-6;
    Quat<T> q_last{0.0, 0.0, 0.0, 0.0};
    Quat<T> q_BN_est{1.0, 0.0, 0.0, 0.0};
    T observability = 0.25;

    template <class V>
    void declare(V& v) {
        v.input("directions_B", directions_B, unit::one, "y_j, unit vectors measured in B, a row for each")
            .unit_vectors();
        v.parameter("directions_N", directions_N, unit::one, "x_j, the same directions in N").fixed().directions();
        v.parameter("weights", weights, unit::one, "a_j; 0: the vector does not count").fixed().at_least(0);
        v.parameter("q_BN_first", q_BN_first, unit::one, "an attitude whose sign the first estimate takes")
            .fixed()
            .unit_quaternion();
        v.parameter("memory_period", memory_period, unit::s, "how often the estimate is remembered for its sign")
            .fixed()
            .above(0);
        v.parameter("limit", limit, unit::one, "observability below which the estimate is held").fixed().above(0);
        v.sampled(memory_period);
        v.held("q_last", q_last, unit::one, "the remembered estimate");
        v.output("q_BN_est", q_BN_est, unit::one, "estimated attitude of B relative to N").unit_quaternion();
        v.output("observability", observability, unit::one, "0: the vectors are collinear");
    }

    void sample(const Sample& /*s*/) {
        outputs();
        q_last = q_BN_est;
    }

    void outputs() {
        const Quat<T> before = q_last.dot(q_last) > 0.0 ? q_last : q_BN_first;
        const Directions<T> x_N = seen<T>(Mat3<T>::Identity(), directions_N);
        const Mat3<T> D = profile(weights, directions_B, x_N);
        const T total = weights.sum();
        T slope;
        const T lambda = largest_root(D, total, slope);
        observability = slope / (8.0 * total * total * total);
        q_BN_est = before;
        if (observability < limit) return;
        q_BN_est = nearest(optimal(D, lambda), before);
    }

    void validate(Words& refuse) const { refuse_blindness(directions_N, weights, refuse); }

private:
    /// What QUEST makes of an attitude profile D.
    struct Terms {
        Mat3<T> S;
        Vec3<T> Z;
        T sigma, kappa, delta;
        explicit Terms(const Mat3<T>& D)
            : S(D + D.transpose()),
              Z(D(1, 2) - D(2, 1), D(2, 0) - D(0, 2), D(0, 1) - D(1, 0)),
              sigma(D.trace()),
              kappa(S(1, 1) * S(2, 2) - S(1, 2) * S(2, 1) + S(0, 0) * S(2, 2) - S(0, 2) * S(2, 0) + S(0, 0) * S(1, 1) -
                    S(0, 1) * S(1, 0)),
              delta(S.determinant()) {}
        T alpha(const T& lambda) const { return lambda * lambda - sigma * sigma + kappa; }
        T gamma(const T& lambda) const { return (lambda + sigma) * alpha(lambda) - delta; }
    };

    /// The largest root of p and the slope of p there. Beyond it p is convex, so Newton's method falls towards it.
    static T largest_root(const Mat3<T>& D, const T& start, T& slope) {
        const Terms q(D);
        const Vec3<T> SZ = q.S * q.Z;
        const T a = q.sigma * q.sigma - q.kappa, b = q.sigma * q.sigma + q.Z.dot(q.Z);
        const T c = q.delta + q.Z.dot(SZ), d = SZ.dot(SZ);
        T lambda = start;
        slope = derivative(lambda, a + b, c);
        for (int i = 0; i < 24 && slope > 0.0; ++i) {
            const T square = lambda * lambda;
            const T change = ((square - a) * (square - b) - c * (lambda - q.sigma) - d) / slope;
            lambda -= change;
            slope = derivative(lambda, a + b, c);
            // at least twice: the first step may be zero in value and yet not in its derivative
            if (i > 0 && change < 1e-14 * start) break;
        }
        return lambda;
    }

    static T derivative(const T& lambda, const T& a_b, const T& c) {
        return 4.0 * lambda * lambda * lambda - 2.0 * a_b * lambda - c;
    }

    static Quat<T> optimal(const Mat3<T>& D, const T& lambda) {
        int best = 0;  // 0: N itself; i: N turned by 180 deg about axis i
        T largest = Terms(D).gamma(lambda);
        for (int i = 1; i <= 3; ++i) {
            const T gamma = Terms(turned(D, i)).gamma(lambda);
            if (gamma > largest) {
                best = i;
                largest = gamma;
            }
        }
        const Terms q(turned(D, best));
        const Vec3<T> SZ = q.S * q.Z;
        const Vec3<T> X = q.alpha(lambda) * q.Z + (lambda - q.sigma) * SZ + q.S * SZ;
        const T gamma = q.gamma(lambda);
        const Quat<T> q_BF = Quat<T>(gamma, X[0], X[1], X[2]) / sqrt(gamma * gamma + X.dot(X));
        if (best == 0) return q_BF;
        Quat<T> q_FN = Quat<T>::Zero();
        q_FN[best] = 1.0;
        return compose(q_BF, q_FN);
    }

    /// D with the known directions as components in the turned frame.
    static Mat3<T> turned(Mat3<T> D, int axis) {
        for (int j = 0; j < 3 && axis > 0; ++j) {
            if (j != axis - 1) D.col(j) = -D.col(j);
        }
        return D;
    }
};

}  // namespace adcs
