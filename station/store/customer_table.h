#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "station/store/store_parts.h"

namespace annulus {

/// Customers, each sealed whole with a key of their own. Thread-bound.
class CustomerTable {
 public:
  explicit CustomerTable(StoreParts& parts) : parts_(parts) {}
  ~CustomerTable() { ForgetNames(); }
  CustomerTable(const CustomerTable&) = delete;
  CustomerTable& operator=(const CustomerTable&) = delete;

  Result<Customer> Add(Customer customer);
  Result<Customer> Get(const std::string& id);
  Status Change(const Customer& customer);
  /// Newest first. A customer whose seal cannot be opened is listed without a name if nothing is searched for.
  Result<std::vector<Customer>> Find(std::string_view search, std::size_t limit);
  /// Those whose time is over, oldest first.
  Result<std::vector<Customer>> Expired();
  Status KeepUntil(const std::string& id, StoreTime until);
  /// As long as a new customer, from now on; never shorter than before.
  Status KeepFromNow(const std::string& id);
  /// Wipes the names that are kept in memory for searching. To be called when another connection has changed rows, and
  /// after a transaction that was undone.
  void ForgetNames();
  /// Wipes one customer's.
  void ForgetNames(const std::string& id);

 private:
  /// A customer in memory, as searched.
  struct Names {
    std::int64_t number = 0;
    std::string id;
    std::string name;
    std::string contact;
  };
  /// Until when who is new is kept.
  Result<StoreTime> EndOfKeeping();
  Status LoadNames();
  void Remember(std::int64_t number, const Customer& customer);
  Result<Customer> Opened(Customer row, const std::vector<std::byte>& sealed);
  Result<std::vector<std::byte>> Sealed(const Customer& customer, const SealKey& key);

  StoreParts& parts_;
  std::optional<std::vector<Names>> names_;  ///< By number; nothing until somebody searches.
};

}  // namespace annulus
