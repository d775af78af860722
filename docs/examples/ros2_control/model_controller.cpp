// An effort controller of ros2_control: the torque of the model along a reference, and a PD for what is left.
//
// The reference comes as trajectory_msgs/msg/JointTrajectoryPoint in ~/reference: position, velocity and acceleration
// of every joint, once for each cycle of the controller manager. Parameters: joints, kp, kd.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include <controller_interface/controller_interface.hpp>
#include <pluginlib/class_list_macros.hpp>
#include <realtime_tools/realtime_buffer.hpp>
#include <trajectory_msgs/msg/joint_trajectory_point.hpp>

#include "delta_model.h"

namespace model_control {

using controller_interface::CallbackReturn;
using controller_interface::InterfaceConfiguration;
using controller_interface::interface_configuration_type;
using controller_interface::return_type;
using Point = trajectory_msgs::msg::JointTrajectoryPoint;

constexpr std::size_t dof = DELTA_MODEL_DOF;

class ModelController : public controller_interface::ControllerInterface {
 public:
  CallbackReturn on_init() override {
    auto_declare<std::vector<std::string>>("joints", {});
    auto_declare<double>("kp", 0.0);
    auto_declare<double>("kd", 0.0);
    return CallbackReturn::SUCCESS;
  }

  InterfaceConfiguration command_interface_configuration() const override { return interfaces({"effort"}); }

  InterfaceConfiguration state_interface_configuration() const override {
    return interfaces({"position", "velocity"});
  }

  CallbackReturn on_configure(const rclcpp_lifecycle::State &) override {
    kp_ = get_node()->get_parameter("kp").as_double();
    kd_ = get_node()->get_parameter("kd").as_double();
    if (get_node()->get_parameter("joints").as_string_array().size() != dof) return CallbackReturn::ERROR;
    subscription_ = get_node()->create_subscription<Point>(
        "~/reference", rclcpp::SystemDefaultsQoS(), [this](const std::shared_ptr<Point> point) {
          if (std::min({point->positions.size(), point->velocities.size(), point->accelerations.size()}) == dof)
            reference_.writeFromNonRT(point);
        });
    return CallbackReturn::SUCCESS;
  }

  CallbackReturn on_activate(const rclcpp_lifecycle::State &) override {
    delta_model_init(&state_);
    reference_.writeFromNonRT(nullptr);  // what was asked for before is no reference now
    return CallbackReturn::SUCCESS;
  }

  CallbackReturn on_deactivate(const rclcpp_lifecycle::State &) override {
    command({});
    return CallbackReturn::SUCCESS;
  }

  return_type update(const rclcpp::Time &, const rclcpp::Duration &period) override {
    const std::shared_ptr<Point> point = *reference_.readFromRT();
    if (!point) return return_type::OK;
    std::array<double, dof> effort{};
    // Of the reference, not of what was measured: at standstill noise would throw the friction to and fro.
    delta_model_torque(&state_, point->positions.data(), point->velocities.data(), point->accelerations.data(),
                       period.seconds(), effort.data());
    for (std::size_t joint = 0; joint < dof; ++joint) {
      effort[joint] += kp_ * (point->positions[joint] - state_interfaces_[2 * joint].get_value()) +
                       kd_ * (point->velocities[joint] - state_interfaces_[2 * joint + 1].get_value());
      if (!std::isfinite(effort[joint])) {  // a position out of reach
        command({});
        return return_type::ERROR;
      }
    }
    command(effort);
    return return_type::OK;
  }

 private:
  InterfaceConfiguration interfaces(const std::vector<std::string> &kinds) const {
    InterfaceConfiguration wanted{interface_configuration_type::INDIVIDUAL, {}};
    for (const auto &joint : get_node()->get_parameter("joints").as_string_array())
      for (const auto &kind : kinds) wanted.names.push_back(joint + "/" + kind);
    return wanted;
  }

  void command(const std::array<double, dof> &effort) {
    for (std::size_t joint = 0; joint < dof; ++joint) command_interfaces_[joint].set_value(effort[joint]);
  }

  delta_model_state state_{};
  double kp_ = 0.0, kd_ = 0.0;
  std::shared_ptr<rclcpp::Subscription<Point>> subscription_;
  realtime_tools::RealtimeBuffer<std::shared_ptr<Point>> reference_;
};

}  // namespace model_control

PLUGINLIB_EXPORT_CLASS(model_control::ModelController, controller_interface::ControllerInterface)
