#include "base/version.h"

#include "commit.h"
#include "version_defaults.h"

namespace vol {

std::string_view version() { return PRECIS_VERSION; }

std::string_view commit() { return PRECIS_COMMIT; }

}  // namespace vol
