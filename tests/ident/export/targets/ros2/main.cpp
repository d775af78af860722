// Steps the example's controller through lines of q, qd, qdd, measured q and qd; prints what it commands.
#include <cstdio>

#include "model_controller.cpp"

int main() {
  model_control::ModelController controller;
  std::vector<double> measured(2 * model_control::dof), effort(model_control::dof);
  for (auto &value : measured) controller.state_interfaces_.push_back({&value});
  for (auto &value : effort) controller.command_interfaces_.push_back({&value});
  controller.node->parameters = {{"joints", {0.0, {"a", "b", "c"}}}, {"kp", {10.0, {}}}, {"kd", {0.5, {}}}};
  if (controller.on_init() != controller_interface::CallbackReturn::SUCCESS || controller.declared.size() != 3) return 1;
  if (controller.on_configure({}) != controller_interface::CallbackReturn::SUCCESS) return 2;
  if (controller.state_interface_configuration().names[3] != "b/velocity") return 3;
  if (controller.command_interface_configuration().names[2] != "c/effort") return 4;
  controller.on_activate({});
  controller.update({}, {0.002});
  if (effort[0] != 0.0) return 5;  // no reference yet
  auto subscription = std::static_pointer_cast<rclcpp::Subscription<model_control::Point>>(controller.node->last_subscription);
  double line[15];
  for (;;) {
    for (double &value : line)
      if (std::scanf("%lf", &value) != 1) return 0;
    auto point = std::make_shared<model_control::Point>();
    point->positions.assign(line, line + 3);
    point->velocities.assign(line + 3, line + 6);
    point->accelerations.assign(line + 6, line + 9);
    for (int joint = 0; joint < 3; ++joint) {
      measured[2 * joint] = line[9 + joint];
      measured[2 * joint + 1] = line[12 + joint];
    }
    subscription->callback(point);
    const bool well = controller.update({}, {0.002}) == controller_interface::return_type::OK;
    std::printf("%d %.17g %.17g %.17g\n", well, effort[0], effort[1], effort[2]);
  }
}
