#pragma once
#include <string_view>

namespace vol {

/// Release, from the newest git tag `vX.Y.Z`.
[[nodiscard]] std::string_view version();

/// `git describe --always --dirty` of the sources that were built, or "unknown" outside a checkout.
[[nodiscard]] std::string_view commit();

}  // namespace vol
