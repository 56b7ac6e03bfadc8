// The unit of a variable: a time derivative is declared with the unit of its state.
#pragma once

#include "fmi/declaration.hpp"

namespace adcs {

class UnitOf {
public:
    explicit UnitOf(const Variable& v) : unit_(v.role == Role::derivative ? nullptr : v.unit), rate_(*v.unit) {}

    const Unit& operator*() const { return unit_ != nullptr ? *unit_ : *rate_; }
    const Unit* operator->() const { return &**this; }

private:
    const Unit* unit_;
    PerSecond rate_;
};

}  // namespace adcs
