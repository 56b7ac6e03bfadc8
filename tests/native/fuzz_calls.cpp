// Random sequences of calls, legal and not, with good, bad and missing arguments, of both versions and interfaces. None
// may crash, hang or answer OK with a value that is not finite, and whatever was saved must continue to the bit.
//
//     fuzz_calls_RigidBody TRIES [FIRST_SEED]
#include "fuzz.hpp"

namespace {

using namespace fuzz;

long calls = 0, succeeded = 0;

class Sequence {
public:
    Sequence(const Subject& subject, std::uint64_t seed)
        : subject_(subject),
          random_(seed),
          tool_(random_.chance(0.5) ? 2 : 3, random_.chance(0.5), subject.token()),
          wild_(random_.chance(0.5) ? 0.0 : 0.2) {}

    void run() {
        const std::size_t length = 10 + random_.below(40);
        for (std::size_t i = 0; i < length; ++i) {
            ++calls;
            if (phase_ == 0 && random_.chance(0.4)) {
                start();
            } else {
                any();
            }
        }
    }

private:
    void start() {
        static constexpr double starts[] = {0.0, 0.0, 0.0, 1.5, -2.0, 1e3};
        time_ = random_.chance(wild_) ? special(random_) : random_.pick(starts);
        const bool stops = random_.chance(0.2);
        if (expect(tool_.enter(time_, stops, time_ + 50.0)) != 0) return;
        phase_ = 1;
        if (random_.chance(0.7) && expect(tool_.exit_initialization()) == 0) phase_ = 2;
    }

    void any() {
        switch (random_.below(14)) {
            case 0:
            case 1:
                expect(subject_.set_any(random_, tool_, wild_));
                break;
            case 2:
                subject_.all(tool_);
                break;
            case 3:
            case 4:
                tool_.cosim() ? step() : model_exchange();
                break;
            case 5:
                round_trip();
                break;
            case 6:
                null_pointers();
                break;
            case 7:
                derivative();
                break;
            case 8:
                if (random_.chance(0.3)) start();
                break;
            case 9:
                if (expect(tool_.exit_initialization()) == 0) phase_ = 2;
                break;
            case 10:
                if (random_.chance(0.1)) expect(tool_.terminate());
                break;
            case 11:
                if (random_.chance(0.2) && expect(tool_.reset()) == 0) {
                    phase_ = 0;
                    time_ = 0.0;
                }
                break;
            case 12:
                tool_.cosim() ? model_exchange() : step();
                break;
            default:
                twin();
                break;
        }
    }

    void step() {
        static constexpr double sizes[] = {0.01, 0.01, 0.01, 0.02, 0.07, 0.3};
        const double size = random_.chance(wild_) ? wild_step() : random_.pick(sizes);
        const double from = random_.chance(0.9) ? time_ : special(random_);
        if (expect(tool_.step(from, size)) == 0) {
            time_ = from + size;
        } else {
            double reached = 0.0;
            if (tool_.get(subject_.table().variables[0], &reached) == 0) time_ = reached;
        }
        subject_.all(tool_);
    }
    double wild_step() {
        static constexpr double sizes[] = {0.0, -0.1, NAN, INFINITY, 1e300, 1e15, 1e-300, 5e-324};
        return random_.pick(sizes);
    }

    void model_exchange() {
        std::vector<double> x(subject_.states() + 1);
        const std::size_t n = random_.chance(0.9) ? subject_.states() : random_.below(x.size());
        switch (random_.below(7)) {
            case 0:
                expect(tool_.update());
                break;
            case 1:
                expect(tool_.enter_continuous());
                break;
            case 2:
                expect(tool_.enter_event());
                break;
            case 3:
                time_ += random_.chance(wild_) ? special(random_) : 0.05;
                expect(tool_.set_time(time_));
                break;
            case 4:
                for (double& value : x) value = random_.chance(wild_) ? special(random_) : random_.uniform();
                expect(tool_.set_states(x.data(), n));
                break;
            case 5:
                if (expect(tool_.get_states(x.data(), n)) == 0) finite(x, n);
                break;
            default:
                if (expect(tool_.derivatives(x.data(), n)) == 0) finite(x, n);
                break;
        }
    }

    void derivative() {
        std::vector<std::uint32_t> unknowns, knowns;
        std::size_t n_seed = 0, n_result = 0;
        for (int i = 0; i < 3; ++i) {
            const Variable &u = subject_.any(random_), &k = subject_.any(random_);
            unknowns.push_back(u.vr);
            knowns.push_back(k.vr);
            n_result += tool_.version() == 2 ? 1 : u.size;
            n_seed += tool_.version() == 2 ? 1 : k.size;
        }
        std::vector<double> seed(n_seed, 1.0), result(n_result, 0.0);
        if (random_.chance(wild_)) seed[0] = special(random_);
        const int status = tool_.version() == 2
                               ? int{fmi2GetDirectionalDerivative(tool_.handle(), unknowns.data(), 3, knowns.data(), 3,
                                                                  seed.data(), result.data())}
                               : int{fmi3GetDirectionalDerivative(tool_.handle(), unknowns.data(), 3, knowns.data(), 3,
                                                                  seed.data(), n_seed, result.data(), n_result)};
        if (expect(status) == 0) finite(result, n_result);
        if (tool_.version() != 3) return;
        std::vector<double> weights(n_result, 1.0), transposed(n_seed, 0.0);
        if (random_.chance(wild_)) weights[0] = special(random_);
        if (random_.chance(wild_)) transposed.push_back(0.0);  // one more than there are
        if (expect(int{fmi3GetAdjointDerivative(tool_.handle(), unknowns.data(), 3, knowns.data(), 3, weights.data(),
                                                n_result, transposed.data(), transposed.size())}) == 0) {
            finite(transposed, n_seed);
        }
    }

    /// Saved, changed and restored: the same values as before.
    void round_trip() {
        void* state = nullptr;
        if (expect(tool_.save(&state)) != 0) return;
        const auto before = subject_.all(tool_);
        require(tool_.restore(state) == 0, "an own state is refused");
        for (std::size_t i = random_.below(4); i > 0; --i) {
            subject_.set_any(random_, tool_, wild_);
            if (tool_.cosim()) tool_.step(time_, 0.01);
        }
        require(tool_.restore(state) == 0, "an own state is refused after changes");
        require(same(before, subject_.all(tool_)), "values differ after a restore");
        require(tool_.restore(state) == 0, "an own state is refused the second time");
        tool_.free_state(&state);
    }

    /// Another instance, given the state as bytes, does the same.
    void twin() {
        void *state = nullptr, *given = nullptr;
        std::vector<unsigned char> bytes;
        if (expect(tool_.save(&state)) != 0) return;
        require(tool_.to_bytes(state, bytes) == 0, "serialise");
        Tool other(tool_.version(), tool_.cosim(), subject_.token());
        require(other.from_bytes(bytes, &given) == 0, "deserialise");
        require(other.restore(given) == 0, "a state is refused by another instance");
        for (int i = 0; i < 3 && tool_.cosim(); ++i) {
            const double size = random_.chance(0.5) ? 0.01 : 0.13;
            const int one = tool_.step(time_, size), two = other.step(time_, size);
            require(one == two, "one of two equal instances fails");
            if (one == 0) time_ += size;
        }
        require(same(subject_.all(tool_), subject_.all(other)), "two equal instances differ");
        double reached = 0.0;
        if (tool_.get(subject_.table().variables[0], &reached) == 0) time_ = reached;
        tool_.free_state(&state);
        other.free_state(&given);
    }

    /// What is missing is an error, whatever the mode.
    void null_pointers() {
        void* c = tool_.handle();
        const std::uint32_t vr = 0;
        double x = 0.0;
        std::size_t size = 0;
        std::vector<int> statuses;
        if (tool_.version() == 2) {
            statuses = {fmi2GetReal(c, nullptr, 1, &x),
                        fmi2GetReal(c, &vr, 1, nullptr),
                        fmi2SetReal(c, nullptr, 1, &x),
                        fmi2SetReal(c, &vr, 1, nullptr),
                        fmi2GetInteger(c, nullptr, 1, nullptr),
                        fmi2SetInteger(c, nullptr, 1, nullptr),
                        fmi2GetBoolean(c, nullptr, 1, nullptr),
                        fmi2SetString(c, nullptr, 1, nullptr),
                        fmi2GetFMUstate(c, nullptr),
                        fmi2SetFMUstate(c, nullptr),
                        fmi2SerializedFMUstateSize(c, nullptr, nullptr),
                        fmi2SerializeFMUstate(c, nullptr, nullptr, 0),
                        fmi2DeSerializeFMUstate(c, nullptr, 100, nullptr),
                        fmi2GetDirectionalDerivative(c, nullptr, 1, nullptr, 1, nullptr, nullptr),
                        fmi2NewDiscreteStates(c, nullptr),
                        fmi2CompletedIntegratorStep(c, 1, nullptr, nullptr),
                        fmi2SetDebugLogging(c, 1, 1, nullptr),
                        fmi2GetRealStatus(c, fmi2LastSuccessfulTime, nullptr),
                        fmi2DoStep(nullptr, 0.0, 0.1, 0)};
            fmi2FreeFMUstate(c, nullptr);
        } else {
            statuses = {fmi3GetFloat64(c, nullptr, 1, &x, 1),
                        fmi3GetFloat64(c, &vr, 1, nullptr, 1),
                        fmi3SetFloat64(c, nullptr, 1, &x, 1),
                        fmi3SetFloat64(c, &vr, 1, nullptr, 1),
                        fmi3GetInt32(c, nullptr, 1, nullptr, 1),
                        fmi3SetInt32(c, nullptr, 1, nullptr, 1),
                        fmi3GetBoolean(c, nullptr, 1, nullptr, 1),
                        fmi3SetBinary(c, nullptr, 1, nullptr, nullptr, 1),
                        fmi3GetIntervalDecimal(c, nullptr, 1, nullptr, nullptr),
                        fmi3GetFMUState(c, nullptr),
                        fmi3SetFMUState(c, nullptr),
                        fmi3SerializedFMUStateSize(c, nullptr, nullptr),
                        fmi3SerializeFMUState(c, nullptr, nullptr, 0),
                        fmi3DeserializeFMUState(c, nullptr, 100, nullptr),
                        fmi3GetDirectionalDerivative(c, nullptr, 1, nullptr, 1, nullptr, 1, nullptr, 1),
                        fmi3GetAdjointDerivative(c, nullptr, 1, nullptr, 1, nullptr, 1, nullptr, 1),
                        fmi3UpdateDiscreteStates(c, nullptr, nullptr, nullptr, nullptr, nullptr, nullptr),
                        fmi3CompletedIntegratorStep(c, true, nullptr, nullptr),
                        fmi3GetNumberOfContinuousStates(c, nullptr),
                        fmi3GetNumberOfEventIndicators(c, nullptr),
                        fmi3DoStep(c, time_, 0.1, true, nullptr, nullptr, nullptr, nullptr),
                        fmi3SetDebugLogging(c, true, 1, nullptr),
                        fmi3Reset(nullptr)};
            fmi3FreeFMUState(c, nullptr);
        }
        for (const int status : statuses) require(status == 3, "NULL is accepted");
        if (subject_.states() != 0 && !tool_.cosim()) {
            require(tool_.get_states(nullptr, subject_.states()) == 3, "NULL for states is accepted");
            require(tool_.derivatives(nullptr, subject_.states()) == 3, "NULL for derivatives is accepted");
            require(tool_.set_states(nullptr, subject_.states()) == 3, "NULL as states is accepted");
        }
        calls += static_cast<long>(statuses.size() + size);
    }

    int expect(int status) {
        // 2, discard, is of a state at which a law has no values, which an integrator has tried
        require(status == 0 || status == 3 || (status == 2 && !tool_.cosim()), "a status that no call has");
        succeeded += status == 0 ? 1 : 0;
        return status;
    }
    static void finite(const std::vector<double>& values, std::size_t n) {
        for (std::size_t i = 0; i < n; ++i) require(std::isfinite(values[i]), "a value is not finite, but OK");
    }

    const Subject& subject_;
    Random random_;
    Tool tool_;
    double wild_;
    double time_ = 0.0;
    int phase_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
    const std::uint64_t tries = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 300;
    const std::uint64_t first = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
    const Subject subject;
    for (std::uint64_t seed = first; seed < first + tries; ++seed) {
        report.seed = seed;
        watch(30);
        Sequence(subject, seed).run();
    }
    std::printf("%s: %llu sequences of %ld calls, %ld of them OK: all survived\n", report.component,
                static_cast<unsigned long long>(tries), calls, succeeded);
    return 0;
}
