from setuptools import find_packages, setup

package_name = "marine_model"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(),
    package_data={
        package_name: [
            "py.typed",
            "data/*.csv",
            "data/*.yaml",
            "drive_files/*.yaml",
            "propeller_files/*.yaml",
            "vessels/*.yaml",
            "wave_response/*.csv",
        ]
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package_name}"]),
        (f"share/{package_name}", ["package.xml"]),
    ],
    install_requires=["setuptools", "numba", "numpy", "pydantic", "pyyaml", "scipy"],
    zip_safe=False,
    description="Shared vocabulary of the dynamic-positioning stack.",
    license="Apache-2.0",
)
