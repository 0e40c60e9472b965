from glob import glob

from setuptools import setup

package_name = "dp_bringup"

setup(
    name=package_name,
    version="0.1.0",
    packages=[],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
        (f"share/{package_name}/launch", glob("launch/*.launch.py")),
        (f"share/{package_name}/config", glob("config/*")),
        (f"share/{package_name}/scenarios", glob("scenarios/*.yaml")),
        (f"share/{package_name}/open_water", glob("open_water/*.yaml")),
    ],
    install_requires=["setuptools"],
    zip_safe=False,
    description="Launch, parameter and scenario files of the dynamic-positioning graph.",
    license="Apache-2.0",
)
