// Stands in for ROS 2's header, with as much of its interface as the example uses.
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace rclcpp {
struct Time {};
struct Duration {
  double value;
  double seconds() const { return value; }
};
struct SystemDefaultsQoS {};
template <typename Message>
struct Subscription {
  std::function<void(std::shared_ptr<Message>)> callback;
};
struct Parameter {
  double number;
  std::vector<std::string> names;
  double as_double() const { return number; }
  std::vector<std::string> as_string_array() const { return names; }
};
}  // namespace rclcpp

namespace rclcpp_lifecycle {
struct State {};
struct LifecycleNode {
  std::map<std::string, rclcpp::Parameter> parameters;
  rclcpp::Parameter get_parameter(const std::string &name) const { return parameters.at(name); }
  template <typename Message, typename Callback>
  std::shared_ptr<rclcpp::Subscription<Message>> create_subscription(const std::string &, rclcpp::SystemDefaultsQoS,
                                                                     Callback callback) {
    auto made = std::make_shared<rclcpp::Subscription<Message>>();
    made->callback = callback;
    last_subscription = made;
    return made;
  }
  std::shared_ptr<void> last_subscription;
};
}  // namespace rclcpp_lifecycle

namespace hardware_interface {
struct LoanedInterface {
  double *value;
  double get_value() const { return *value; }
  void set_value(double next) { *value = next; }
};
}  // namespace hardware_interface

namespace controller_interface {
enum class CallbackReturn { SUCCESS, FAILURE, ERROR };
enum class return_type { OK, ERROR };
enum class interface_configuration_type { ALL, INDIVIDUAL, NONE };
struct InterfaceConfiguration {
  interface_configuration_type type;
  std::vector<std::string> names;
};
class ControllerInterface {
 public:
  virtual ~ControllerInterface() = default;
  virtual CallbackReturn on_init() = 0;
  virtual InterfaceConfiguration command_interface_configuration() const = 0;
  virtual InterfaceConfiguration state_interface_configuration() const = 0;
  virtual CallbackReturn on_configure(const rclcpp_lifecycle::State &) = 0;
  virtual CallbackReturn on_activate(const rclcpp_lifecycle::State &) = 0;
  virtual CallbackReturn on_deactivate(const rclcpp_lifecycle::State &) = 0;
  virtual return_type update(const rclcpp::Time &, const rclcpp::Duration &) = 0;
  std::shared_ptr<rclcpp_lifecycle::LifecycleNode> get_node() const { return node; }
  template <typename Value>
  void auto_declare(const std::string &name, const Value &) { declared.push_back(name); }

  std::shared_ptr<rclcpp_lifecycle::LifecycleNode> node = std::make_shared<rclcpp_lifecycle::LifecycleNode>();
  std::vector<std::string> declared;
  std::vector<hardware_interface::LoanedInterface> command_interfaces_, state_interfaces_;
};
}  // namespace controller_interface
