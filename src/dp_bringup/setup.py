from glob import glob

from setuptools import find_packages, setup

package_name = "dp_bringup"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(),
    package_data={package_name: ["py.typed"]},
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
    description="Brings the dynamic-positioning graph up: processes, launch, parameter and scenario files.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "composed = dp_bringup.composed:main",
            "supervisor = dp_bringup.supervisor.main:main",
        ]
    },
)
