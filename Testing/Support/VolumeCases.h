// Transfer functions of every kind, for values in [0, 1], and fields of every kind: what volumes have to be right for.
#pragma once

#include "Field/TransferFunction.h"

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace treeamr::test
{

template <class T>
using Named = std::vector<std::pair<std::string, T>>;

using Point = std::array<double, 3>;

/// At points of [0, 2]^3. The shock is from 0 to 1000, of which functions see a thousandth.
Named<std::function<double(const Point&)>> volumeFieldValues();
/// On cells of several levels.
Named<std::shared_ptr<const Field>> volumeFields();

/// Of nodes.
Named<TransferFunction> volumeFunctions();

} // namespace treeamr::test
