from setuptools import find_packages, setup

package_name = "dp_tools"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(),
    package_data={package_name: ["py.typed", "report/templates/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=False,
    description="The dp command.",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            "dp = dp_tools.cli:main",
            "disturber = dp_tools.disturber.node:main",
            "recorder = dp_tools.recorder.node:main",
        ],
    },
)
