from setuptools import find_packages, setup

package_name = "thruster_drivers"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(),
    package_data={package_name: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
    ],
    install_requires=["setuptools", "numpy", "pydantic", "scipy"],
    zip_safe=False,
    description="Local thruster control of the dynamic-positioning stack.",
    license="Apache-2.0",
    entry_points={"console_scripts": ["node = thruster_drivers.node:main"]},
)
