#pragma once

#include <string>
#include <vector>

#include "base/result.h"
#include "station/store/store_parts.h"

namespace annulus {

/// What customers have agreed to. Nothing is changed later but the time of a withdrawal. Thread-bound.
class ConsentTable {
 public:
  explicit ConsentTable(StoreParts& parts) : parts_(parts) {}

  /// Fails unless all purposes are of those that there are.
  Result<Consent> Add(Consent consent);
  /// A customer's, oldest first.
  Result<std::vector<Consent>> Of(const std::string& customer_id);
  Status Withdraw(const std::string& id);
  /// Fails unless the consent is this customer's and in force.
  Status CheckInForce(const std::string& id, const std::string& customer_id);

 private:
  StoreParts& parts_;
};

}  // namespace annulus
