//! A robot's DDS on Zenoh, as Eclipse's `zenoh-bridge-ros2dds -c FILE`: settings from one file, one plugin, no others.

use zenoh::internal::{plugins::PluginsManager, runtime::RuntimeBuilder};

#[tokio::main]
async fn main() -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    zenoh::init_log_from_env_or("warn");
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [option, file] = arguments.as_slice() else {
        return Err("usage: zenoh-bridge-ros2dds -c FILE.json5".into());
    };
    if option != "-c" && option != "--config" {
        return Err("usage: zenoh-bridge-ros2dds -c FILE.json5".into());
    }
    let mut plugins = PluginsManager::static_plugins_only();
    plugins.declare_static_plugin::<zenoh_plugin_ros2dds::ROS2Plugin, _>("ros2dds", true);
    let config = zenoh::Config::from_file(file)?;
    let mut runtime = RuntimeBuilder::new(config).plugins_manager(plugins).build().await?;
    runtime.start().await?;
    std::future::pending().await
}
