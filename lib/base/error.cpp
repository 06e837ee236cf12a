#include "base/error.h"

namespace vol {

Error::Error(const std::string& context, const std::exception& cause)
    : std::runtime_error(context + ": " + cause.what()) {}

}  // namespace vol
